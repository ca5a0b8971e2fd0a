"""Messages of the command name its own options and commands, not functions of Python."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import igl
import pytest
from conftest import ROOT

from igl_linabf.cli import main
from igl_linabf.cli.arguments import list_flags
from igl_linabf.cli.parser import COMMANDS
from igl_linabf.cli.wording import CLASSES, name_options


def iterate_texts() -> Iterator[str]:
    """Yield the texts in the package, with {} for each formatted value; docstrings are not texts."""
    for path in (ROOT / "igl_linabf").rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        inner = {
            id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values
        }
        inner |= {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            if isinstance(node, ast.JoinedStr):
                yield "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in inner:
                yield node.value


@pytest.mark.parametrize("name", COMMANDS)
def test_each_option_replaces_its_parameter(name: str) -> None:
    for parameter, (flag, takes_value) in list_flags(COMMANDS[name]).items():
        wanted = f"{flag} 3" if takes_value else flag
        for text in (f"{parameter}=3", f"charts=ChartOptions({parameter}=3)", f"{parameter}='3'"):
            assert name_options(f"use {text}, or less", COMMANDS[name], COMMANDS) == f"use {wanted}, or less"
        for text in (f"/data/{parameter}.obj", f"{parameter}_3=3", f"my-{parameter}.obj"):
            assert name_options(text, COMMANDS[name], COMMANDS) == text


def test_no_message_of_the_package_recommends_a_call_of_python() -> None:
    texts = [text for text in iterate_texts() if (" " in text and "igl_linabf" in text) or "=True" in text]
    assert len(texts) > 20
    for text in texts:
        named = name_options(text, COMMANDS["unwrap"], COMMANDS)
        assert not re.search(rf"\b({CLASSES})\(\w+=|\bigl_linabf\.({'|'.join(COMMANDS)})\b", named), named


def test_a_mesh_that_flatten_refuses_is_for_the_command_unwrap(tmp_path: Path, capsys) -> None:
    igl.write_triangle_mesh(str(tmp_path / "in.off"), *igl.icosahedron())
    assert main(["flatten", str(tmp_path / "in.off"), "-o", str(tmp_path / "out.obj")]) == 2
    assert "use igl-linabf unwrap, which makes an atlas" in capsys.readouterr().err
    words = ["unwrap", str(tmp_path / "in.off"), "-o", str(tmp_path / "out.obj"), "--cones", "auto"]
    assert main([*words, "--max-charts", "3"]) == 2
    assert "--cones and --max-charts do not go together" in capsys.readouterr().err
