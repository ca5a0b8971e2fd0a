"""The fallback of converged ABF after it has no map: linear ABF's."""

from dataclasses import replace

from .attempts import Candidate, Problem, Stage, Tried

NOTE = "converged ABF has no map in double precision: this is the map of linear ABF"


def linear_instead(linear: Stage) -> Stage:
    """The map of a stage of linear ABF, where no stage of converged ABF has one in double precision.

    Prescribed angle sums can press triangles so flat that the system of their minimum is singular. Steps of
    linear ABF also end there, at angles that can be laid out.
    """

    def stage(problem: Problem, tried: Tried) -> Candidate | None:
        if any(made.layout is not None for made in tried):
            return None
        made = linear(problem, tried)
        return None if made is None else replace(made, converged=False, note=NOTE)

    return stage
