"""Every patch of tests/mutants.diff can be applied, and changes the program."""

from __future__ import annotations

import ast

import mutants
import pytest
from conftest import ROOT

MUTANTS = mutants.parse_mutants(mutants.MUTANTS.read_text("utf-8"))


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: f"{mutant.room}: {mutant.property}")
def test_a_mutant_changes_the_program_and_its_tests_exist(mutant: mutants.Mutant) -> None:
    assert ast.dump(ast.parse(mutant.source())) != ast.dump(ast.parse(mutant.path.read_text("utf-8")))
    assert mutant.tests
    for words in mutant.tests.split():
        assert (ROOT / words.split("::")[0]).exists()


def test_lines_that_do_not_occur_exactly_once_are_named() -> None:
    patch = "# measures: nothing | tests\n--- a/igl_linabf/measures/figures.py\n@@\n-    return\n+    pass\n"
    (mutant,) = mutants.parse_mutants(patch)
    with pytest.raises(
        ValueError, match=r"figures\.py: the lines of the mutant 'nothing' stand there \d+ times"
    ):
        mutant.source()
