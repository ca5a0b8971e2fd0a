"""A release has lazy imports, a command, wheels, and consistent metadata and workflows."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import inspect
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import time
from functools import cache
from importlib import metadata
from pathlib import Path

import pytest
import yaml
from conftest import ROOT, build_wheel
from scripts_of_repo import script

import igl_linabf
from igl_linabf.cli.doctor import EXTRAS, NEEDED

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT, TOOL = PYPROJECT["project"], PYPROJECT["tool"]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
HEAVY = ("numpy", "scipy", "igl", "igl_linabf._core", "shapely", "pyvista")


def python(*arguments: str, **options: object) -> str:
    """Run Python in a new process, and return its output."""
    process = subprocess.run(
        [sys.executable, *arguments], **{"capture_output": True, "text": True, "timeout": 3600, **options}
    )
    assert process.returncode == 0, process.stderr
    return process.stdout


def test_nothing_is_imported_before_it_is_used() -> None:
    code = """
import json, sys
import igl_linabf, igl_linabf.__main__
bare = [name for name in sys.argv[1:] if name in sys.modules]
igl_linabf.linabf
print(json.dumps([bare, "numpy" in sys.modules]))
"""
    assert json.loads(python("-c", code, *HEAVY)) == [[], True]


def test_public_names_can_be_imported_in_every_way() -> None:
    code = """
import igl_linabf
assert set(igl_linabf.__all__) <= set(dir(igl_linabf))
from igl_linabf import *
assert igl_linabf.errors.MeshError is MeshError and len(igl_linabf.__all__) <= 30
for name in igl_linabf.__all__:
    assert globals()[name] is getattr(igl_linabf, name), name
rooms = set(dir(igl_linabf)) - set(igl_linabf.__all__)
assert {"textures", "uv", "batch", "plot", "io"} < rooms
for name in rooms:
    assert getattr(igl_linabf, name) is not None, name
try:
    igl_linabf.lin_abf
except AttributeError as error:
    print(error)
"""
    assert python("-c", code) == "module 'igl_linabf' has no attribute 'lin_abf'\n"


@pytest.mark.slow
def test_a_type_checker_sees_every_name_and_no_other(tmp_path) -> None:
    pytest.importorskip("mypy")
    names = "\n".join(f"igl_linabf.{name}" for name in igl_linabf.__all__)
    (tmp_path / "use.py").write_text(f"import igl_linabf\n{names}\nigl_linabf.lin_abf\n")
    options = ("--strict", "--follow-imports=silent", "--ignore-missing-imports")
    process = subprocess.run(
        [sys.executable, "-m", "mypy", *options, "use.py"],
        cwd=tmp_path,
        capture_output=True,
        encoding="utf-8",
        timeout=3600,
        env={**os.environ, "MYPYPATH": str(ROOT)},
    )
    errors = [line for line in process.stdout.splitlines() if "error:" in line]
    assert len(errors) == 1, process.stdout
    assert 'Module has no attribute "lin_abf"' in errors[0]


def test_the_package_is_a_command_and_prints_its_version() -> None:
    assert python("-m", "igl_linabf", "--version") == f"igl-linabf {PROJECT['version']}\n"
    module, _, function = PROJECT["scripts"]["igl-linabf"].partition(":")
    assert inspect.isfunction(getattr(importlib.import_module(module), function))


@cache
def completion() -> str:
    """Return the completion script that the command prints for bash."""
    return python("-m", "igl_linabf", "--print-completion", "bash")


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["fl"], {"flatten"}),
        (["unwrap", "--rep"], {"--repair-overlaps"}),
        (["flatten", "x.obj", "--layout", ""], {"auto", "boundary", "least-squares", "greedy"}),
        (["compare", "bu"], {"bumps.obj"}),
    ],
)
def test_bash_completes_commands_options_values_and_files(words, expected, tmp_path) -> None:
    pytest.importorskip("shtab")
    (tmp_path / "bumps.obj").write_text("")
    (tmp_path / "completion").write_text(completion())
    asked = f"""
source completion
COMP_WORDS=(igl-linabf {" ".join(word or '""' for word in words)})
COMP_CWORD={len(words)}
[ -n "${{COMP_WORDS[-1]//\\"}}" ] || COMP_WORDS[-1]=""
_shtab_igl_linabf igl-linabf "${{COMP_WORDS[-1]}}"
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
    process = subprocess.run(
        ["bash", "-c", asked], cwd=tmp_path, capture_output=True, encoding="utf-8", timeout=3600
    )
    assert set(process.stdout.split()) == expected, process.stderr


@pytest.mark.slow
def test_the_wheel_is_one_typed_module_with_a_page_whose_links_lead_somewhere(tmp_path) -> None:
    script("release_check.py").check_wheel(build_wheel(tmp_path))


def test_an_editable_install_builds_the_core_again_where_a_source_has_changed(tmp_path, monkeypatch) -> None:
    from igl_linabf._core import _editable

    class Loader:
        built, fails = 0, False

        def rebuild(self) -> None:
            assert os.environ["PATH"].startswith(sysconfig.get_path("scripts"))
            self.built += 1
            if self.fails:
                raise subprocess.CalledProcessError(1, "cmake")

    source = tmp_path / "igl_linabf" / "_core" / "src" / "cholesky" / "cholesky.hpp"
    source.parent.mkdir(parents=True)
    for path in (source, tmp_path / "CMakeLists.txt", source.parent, source.parent.parent):
        path.touch()
        os.utime(path, (0, 0))
    monkeypatch.setattr(_editable, "HERE", source.parents[2])
    loader = Loader()
    _editable.rebuild_if_changed(loader)
    assert loader.built == 0
    later = time.time() + 3600
    os.utime(source, (later, later))
    _editable.rebuild_if_changed(loader)
    assert loader.built == 1
    loader.fails = True
    path = os.environ["PATH"]
    with pytest.raises(ImportError, match="could not be built again"):
        _editable.rebuild_if_changed(loader)
    assert os.environ["PATH"] == path


def test_the_conda_recipe_has_the_build_requirements_of_the_package() -> None:
    recipe = yaml.safe_load((ROOT / "conda" / "recipe.yaml").read_text(encoding="utf-8"))
    wanted = {text.replace(">=", " >=") for text in PYPROJECT["build-system"]["requires"]}
    assert set(recipe["requirements"]["host"]) == wanted | {"python", "pip"}
    assert '${{ compiler("cxx") }}' in recipe["requirements"]["build"]


def test_the_page_of_the_index_links_to_existing_files() -> None:
    rules = TOOL["hatch"]["metadata"]["hooks"]
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    for rule in rules["fancy-pypi-readme"]["substitutions"]:
        page = re.sub(rule["pattern"], rule["replacement"].replace("$HFPR_VERSION", "0"), page)
    base = re.compile(
        r"https://(?:github\.com|raw\.githubusercontent\.com)/igl-linabf/igl_linabf/(?:blob/)?v0/(.*)"
    )
    links = re.findall(r"\]\(([^)\s]+)\)", page)
    here = [match[1] for link in links if (match := base.match(link))]
    assert len(here) > 10
    assert any(path.endswith(".png") for path in here)
    assert all((ROOT / path.partition("#")[0]).is_file() for path in here)
    assert all(link.startswith("https://") for link in links)


def package_names(requirements: list[str]) -> list[str]:
    return [re.match(r"[\w-]+", text)[0] for text in requirements]


def test_the_doctor_checks_every_dependency_of_users() -> None:
    optional = PROJECT["optional-dependencies"]
    for_developers = {"all", "demos", "docs", "peers", "test"}
    assert list(NEEDED) == package_names(PROJECT["dependencies"])
    assert {
        extra: tuple(package_names(packages))
        for extra, packages in optional.items()
        if extra not in for_developers
    } == EXTRAS


def test_the_page_on_installing_names_every_extra_and_every_package_that_is_needed() -> None:
    text = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE))
    assert set(PROJECT["optional-dependencies"]) <= shown
    assert ", ".join(NEEDED[:-1]) + f" and {NEEDED[-1]}" in " ".join(text.split())


def test_the_excluded_tests_of_the_release_check_exist() -> None:
    left_out = script("release_check.py").EXCLUDED_TESTS
    assert [name for name in left_out if not (ROOT / "tests" / name).is_file()] == []


def test_the_wheels_are_those_of_the_pythons_that_the_package_supports() -> None:
    built = TOOL["cibuildwheel"]["build"]
    stable = TOOL["scikit-build"]["wheel"]["py-api"]
    listed = [f"cp3{c.rpartition('.')[2]}" for c in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", c)]
    assert built == [f"{name}-*" for name in listed if len(name) == 5 and name <= stable]
    release_check = script("release_check.py")
    assert tuple(TOOL["cibuildwheel"]["test-requires"]) == release_check.TEST_REQUIREMENTS
    wheels = [Path("igl_linabf-1-cp310-cp310-any.whl"), Path("igl_linabf-1-cp312-abi3-any.whl")]
    fitting = {
        minor: [release_check.is_compatible(wheel, (3, minor)) for wheel in wheels] for minor in range(10, 15)
    }
    assert fitting == {
        10: [True, False],
        11: [False, False],
        **{minor: [False, True] for minor in (12, 13, 14)},
    }


def test_all_files_have_the_same_version() -> None:
    recipe = yaml.safe_load((ROOT / "conda" / "recipe.yaml").read_text(encoding="utf-8"))
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert recipe["context"]["version"] == citation["version"] == PROJECT["version"]
    assert igl_linabf.__version__ == metadata.version("igl-linabf")


def test_the_conda_recipe_has_the_dependencies_of_the_package() -> None:
    recipe = yaml.safe_load((ROOT / "conda" / "recipe.yaml").read_text(encoding="utf-8"))
    wanted = {re.sub(r"^libigl\b", "igl", text).replace(">=", " >=") for text in PROJECT["dependencies"]}
    assert set(recipe["requirements"]["run"]) == wanted | {f"python {PROJECT['requires-python']}"}
    (entry,) = recipe["build"]["python"]["entry_points"]
    assert entry == f"igl-linabf = {PROJECT['scripts']['igl-linabf']}"


def test_classifiers_and_workflow_have_the_same_python_versions() -> None:
    listed = [c.rpartition(" ")[2] for c in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", c)]
    matrix = yaml.safe_load((ROOT / ".github/workflows/tests.yml").read_text(encoding="utf-8"))["jobs"][
        "tests"
    ]["strategy"]
    assert matrix["matrix"]["python"] == listed
    assert PROJECT["requires-python"] == f">={listed[0]}"
    assert {name.partition("-")[0] for name in matrix["matrix"]["os"]} == {"ubuntu", "macos", "windows"}


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_workflows_run_existing_targets_and_files(path: Path) -> None:
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    jobs = yaml.safe_load(path.read_text(encoding="utf-8"))["jobs"]
    for job in jobs.values():
        needs = job.get("needs", [])
        assert {needs} if isinstance(needs, str) else set(needs) <= set(jobs)
        if "uses" in job:
            assert (ROOT / job["uses"]).is_file()
    asked = set(re.findall(r"run: make ([\w-]+)", path.read_text(encoding="utf-8")))
    assert asked <= targets
    assert asked or path.name == "publish.yml"


def test_publication_needs_no_token() -> None:
    text = (ROOT / ".github/workflows/publish.yml").read_text(encoding="utf-8")
    publish = yaml.safe_load(text)["jobs"]["publish"]
    assert publish["permissions"] == {"id-token": "write"}
    assert publish["needs"] == "wheels"
    wheels = (ROOT / ".github/workflows/wheels.yml").read_text(encoding="utf-8")
    names = re.findall(r"name: (dist\S*)", wheels)
    assert len(names) == 2
    assert all(name.startswith("dist-") for name in names)
    assert "pattern: dist-*" in text
    assert "secrets" not in text


@pytest.mark.parametrize(
    ("schema", "files"),
    [
        ("vendor.github-workflows", [str(path) for path in WORKFLOWS]),
        ("vendor.dependabot", [str(ROOT / ".github" / "dependabot.yml")]),
        (
            "vendor.github-issue-forms",
            [str(ROOT / f".github/ISSUE_TEMPLATE/{n}.yml") for n in ("bug", "feature")],
        ),
        ("vendor.github-issue-config", [str(ROOT / ".github/ISSUE_TEMPLATE/config.yml")]),
        ("vendor.citation-file-format", [str(ROOT / "CITATION.cff")]),
    ],
    ids=["workflows", "dependabot", "issue forms", "issues", "citation"],
)
def test_metadata_files_match_their_schemas(schema: str, files: list[str]) -> None:
    pytest.importorskip("check_jsonschema")
    kind = ["--default-filetype", "yaml"]
    python("-m", "check_jsonschema", "--builtin-schema", schema, *kind, *files)


def test_bug_reports_must_include_the_output_of_the_doctor() -> None:
    form = yaml.safe_load((ROOT / ".github/ISSUE_TEMPLATE/bug.yml").read_text(encoding="utf-8"))
    (field,) = (part for part in form["body"] if "igl-linabf doctor" in part["attributes"]["label"])
    assert field["validations"]["required"]


def test_pre_commit_runs_the_ruff_of_the_tests() -> None:
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))["repos"]
    (rev,) = (hook["rev"] for hook in hooks if "ruff" in hook["repo"])
    (pinned,) = (text for text in PROJECT["optional-dependencies"]["test"] if text.startswith("ruff"))
    assert pinned == f"ruff=={rev[1:]}"
