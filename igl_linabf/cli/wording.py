"""Name the options of the command in messages of the library, which name the parameters of its functions.

Messages refer to Python in three forms, and therefore no message needs its own rule: `name=value` for a
parameter, `ChartOptions(name=value)` for a field of an options class, and `igl_linabf.unwrap` for a function.
"""

import re
from collections.abc import Mapping

from .arguments import Command, list_flags

CLASSES = "ChartOptions|Packing|Cones|LinABF|ABF|Isometric"
VALUE = r"'[^']*'|\"[^\"]*\"|[\w.-]*\w"
BEGIN = r"(?<![\w/\\.-])"  # not within a path or a longer name
END = r"(?![\w/\\(\[-]|\.\w)"
CONSTRUCTOR = re.compile(
    rf"(?:\b\w+=)?(?:\bigl_linabf\.)?\b(?:{CLASSES})\(((?:[^()'\"]|'[^']*'|\"[^\"]*\")+)\)"
)
PARAMETER = re.compile(rf"{BEGIN}([a-z]\w*)(?:=| = )({VALUE})?{END}")
COMPOUND = re.compile(rf"{BEGIN}([a-z]+_\w+)(){END}(?!=)")  # a name with an underscore, which is not prose
FUNCTION = re.compile(r"\bigl_linabf\.((?:\w+\.)*(\w+))(\(V, F(?:, [^()]*)?\))?")
FIELDS = {"angles": "cone_angles"}  # fields of options classes whose options have other names
COMMAND_OF_FUNCTION = {"flatten_files": "batch", "check_uv": "check", "write_pattern": "pattern"}


def name_options(text: str, command: Command, commands: Mapping[str, Command]) -> str:
    """Replace the parameters and functions in a message by options and commands.

    Parameters
    ----------
    text : str
    command : function
        The running command.
    commands : mapping
        All commands by name. Messages of other commands also recommend the options of "unwrap" and "pack".

    Returns
    -------
    str
        Parameters without an option are left as they are, and functions without a command are called Python
        functions.
    """
    flags = {**list_flags(commands["pack"]), **list_flags(commands["unwrap"]), **list_flags(command)}

    def write_option(found: re.Match[str]) -> str:
        name = FIELDS.get(found[1], found[1])
        if name not in flags:
            return found[0]
        flag, takes_value = flags[name]
        value = (found[2] or "").strip("'\"").replace("False", "no")
        return f"{flag} {value}" if takes_value and value else flag

    def write_function(found: re.Match[str]) -> str:
        name = COMMAND_OF_FUNCTION.get(found[2], found[2])
        if name in commands:
            return f"igl-linabf {name}"
        return f"the Python function igl_linabf.{found[1]}{found[3] or ''}"

    text = CONSTRUCTOR.sub(lambda found: found[1], text)
    for pattern in (PARAMETER, COMPOUND):
        text = pattern.sub(write_option, text)
    return FUNCTION.sub(write_function, text)
