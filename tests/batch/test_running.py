"""A batch loses no result, repeats no work and leaves no partial file, even if processes die."""

from __future__ import annotations

import csv
import os
import signal
import socket
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from urllib.request import urlopen

import igl
import numpy as np
import psutil
import pytest
from commands import list_session_processes
from conftest import ROOT, bumps
from hostile_methods import Hostile

from igl_linabf import ChartOptions, Cones, MeshError, Packing, unwrap
from igl_linabf.batch import clusters, flatten_files, places, running
from igl_linabf.batch.one_mesh import Settings, run_task
from igl_linabf.batch.running import _plan_tasks
from igl_linabf.batch.table import Row, Table
from igl_linabf.flattening import resolve_method
from igl_linabf.io import read_file, read_mesh, read_texture, write_file

distributed = pytest.importorskip("distributed")
ENTRY = [sys.executable, "-m", "igl_linabf", "batch"]
WAITING = """# the command, with a method that waits for a file at large meshes
import sys

import igl_linabf
import igl_linabf.cli.batching
from igl_linabf.__main__ import main
from hostile_methods import Hostile

def flatten_files(*arguments, **options):
    options["method"] = Hostile(waits=1500, flag="FLAG")
    return igl_linabf.batch.flatten_files(*arguments, **options)

if __name__ == "__main__":
    igl_linabf.cli.batching.flatten_files = flatten_files
    sys.exit(main())
"""
HEADER = "input,output,outcome,message,triangles,charts,F/3nt,stretch,flips,seconds,key"


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """Return the address of a cluster that was started independently of the batch."""
    options = {"host": "127.0.0.1", "dashboard_address": "127.0.0.1:0", "silence_logs": 50}
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, **options) as cluster:
        yield cluster.scheduler_address


def write_disks(folder: Path, sizes: list[int]) -> list[Path]:
    """Write random disks with about the given numbers of vertices."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{k}.obj" for k in range(len(sizes))]
    for k, (path, size) in enumerate(zip(paths, sizes, strict=True)):
        igl.write_triangle_mesh(str(path), *bumps(size, seed=k))
    return paths


def read_results_table(out: Path) -> list[dict[str, str]]:
    """Read the table of results from disk, and check that it is complete."""
    with open(out / "results.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file, strict=True))
    assert all(None not in row and None not in row.values() for row in rows)
    return rows


def snapshot(out: Path) -> dict[str, tuple[int, int]]:
    """Return the inode and the time of each map, which change if the map is written again."""
    maps = (path for path in out.rglob("*.obj") if not path.name.startswith("."))
    return {path.name: (path.stat().st_ino, path.stat().st_mtime_ns) for path in maps}


def list_recorded_maps(out: Path) -> set[str]:
    """Return the names of the valid maps that the table or a journal lists."""
    new = ""
    for journal in out.glob(".results.journal*"):
        with suppress(FileNotFoundError):  # the run removes its journals when it ends
            new += journal.read_text()
    rows = read_results_table(out) if (out / "results.csv").exists() else []
    return {row["output"] for row in rows if row["outcome"] == "valid" or f'"{row["output"]}"' in new}


def test_each_input_has_a_row_and_a_map_with_a_unique_name(scheduler: str, tmp_path: Path) -> None:
    V, F = bumps(100)
    nowhere = np.where(np.arange(len(V))[:, None] == F[0, 0], np.nan, V), F
    surfaces = {
        "a/x.obj": bumps(200, 1),
        "a/x.off": bumps(200, 2),
        "a/X.stl": bumps(200, 3),
        "b/x.obj": bumps(200, 4),
        "b/ü, 'q\".ply": igl.icosahedron(),
        "b/bad.obj": nowhere,
    }
    files = {name: tmp_path / "in" / name for name in surfaces}
    for name, (V, F) in surfaces.items():
        files[name].parent.mkdir(parents=True, exist_ok=True)
        igl.write_triangle_mesh(str(files[name]), V, F)
    (tmp_path / "in/b/damaged.off").write_text("OFF\n3 1 0\n0 0 0\n")
    (tmp_path / "in/b/texture.png").write_text("no mesh")
    out = tmp_path / "in" / "maps"  # maps in the input folder are not inputs
    for _ in range(2):
        done = flatten_files(
            [tmp_path / "in", tmp_path / "in/b/*.o*"], out, scheduler=scheduler, progress=False
        )
        rows = {Path(row.input).relative_to(tmp_path / "in").as_posix(): row for row in done.rows}
        assert set(rows) == {*surfaces, "b/damaged.off"}
        assert not done.good
        assert "7 meshes: 5 valid, 2 refused" in str(done)
        assert rows["b/x.obj"].output == "b/x.obj"
        outputs = {row.output.casefold() for row in rows.values()}
        assert len(outputs) == 7
        assert {path.relative_to(out).as_posix().casefold() for path in out.rglob("*.obj")} == {
            row.output.casefold() for row in rows.values() if row.outcome == "valid"
        }
    assert done.done == 0
    for name, row in rows.items():
        if row.outcome == "refused":
            assert row.message
            continue
        mesh = read_file(files[name])
        V, F = mesh.V, mesh.F
        atlas = unwrap(V, F)
        here = tmp_path / "here.obj"
        write_file(here, mesh, atlas.TC, atlas.FTC)
        assert (out / row.output).read_bytes() == here.read_bytes()
        q = atlas.quality
        measured = (row.triangles, row.charts, row.angle_distortion, row.stretch, row.flips)
        assert measured == (len(F), len(atlas.charts), q.angle_distortion, q.stretch_l2, q.flips)
    on_disk = read_results_table(out)
    assert ",".join(on_disk[0]) == HEADER
    assert [row["input"] for row in on_disk] == [row.input for row in done.rows]
    assert [row["outcome"] for row in on_disk] == [row.outcome for row in done.rows]


def test_parquet_has_the_same_rows(scheduler: str, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    write_disks(tmp_path / "in", [100, 150])
    (tmp_path / "in/damaged.ply").write_text("ply\n")
    done = flatten_files(tmp_path / "in", tmp_path / "out", scheduler=scheduler, progress=False)
    columns = parquet.read_table(tmp_path / "out/results.parquet").to_pydict()
    assert ",".join(columns) == HEADER
    assert columns["F/3nt"] == [row.angle_distortion for row in done.rows]
    assert columns["triangles"] == [row.triangles for row in done.rows]


def test_a_second_run_does_only_missing_and_new_meshes(scheduler: str, tmp_path: Path) -> None:
    paths, out = write_disks(tmp_path / "in", [100, 120, 140, 160, 180]), tmp_path / "out"
    options = {"scheduler": scheduler, "progress": False}
    first = flatten_files(tmp_path / "in", out, **options)
    assert first.done == 5
    before = snapshot(out)
    (out / "0.obj").unlink()
    igl.write_triangle_mesh(str(paths[1]), *bumps(130))
    write_disks(tmp_path / "new", [90])
    shares: list[float] = []
    second = flatten_files(
        [tmp_path / "in", tmp_path / "new"], out, scheduler=scheduler, progress=lambda _, x: shares.append(x)
    )
    after = snapshot(out)
    assert second.done == len(shares) == 3
    assert shares[-1] == 1
    assert {name for name in after if after[name] != before.get(name)} == {
        "0.obj",
        "1.obj",
        second.rows[-1].output,
    }
    assert second.rows[-1].output.startswith("0-")
    assert second.rows[2:5] == first.rows[2:]
    assert flatten_files(tmp_path / "in", out, method="lscm", **options).done == 5
    assert len(read_results_table(out)) == 6  # the row of an earlier run is kept
    (tmp_path / "other").mkdir()
    for foreign in ("a,b\n1,2\n", "", f"{HEADER}\n1,2\n"):
        (tmp_path / "other/results.csv").write_text(foreign)
        with pytest.raises(OSError, match="is not the table of a batch"):
            flatten_files(tmp_path / "in", tmp_path / "other", **options)
        assert (tmp_path / "other/results.csv").read_text() == foreign
    with Table(str(out)), pytest.raises(OSError, match="another batch is writing there"):
        flatten_files(tmp_path / "in", out, **options)


def test_urls_give_the_same_results_as_paths(scheduler: str, tmp_path: Path) -> None:
    write_disks(tmp_path / "in/deep", [100, 120])
    options = {"scheduler": scheduler, "progress": False}
    by_path = flatten_files(tmp_path / "in", tmp_path / "out", **options)
    for _ in range(2):
        by_url = flatten_files(f"file://{tmp_path}/in/", f"file://{tmp_path}/far/out/", **options)
        assert by_url.good
        assert [row.output for row in by_url.rows] == [row.output for row in by_path.rows]
    assert by_url.done == 0
    for row in by_path.rows:
        assert (tmp_path / "far/out" / row.output).read_bytes() == (
            tmp_path / "out" / row.output
        ).read_bytes()
    assert [p.name for p in (tmp_path / "far/out/deep").iterdir() if p.suffix != ".obj"] == []


def list_listening_addresses() -> list[tuple[str, int]]:
    """Return the network addresses where this process and its children listen."""
    found = []
    for process in (psutil.Process(), *psutil.Process().children(recursive=True)):
        with suppress(psutil.NoSuchProcess):  # the process has ended in the meantime
            for connection in process.net_connections("inet"):
                if connection.status == psutil.CONN_LISTEN or connection.type == socket.SOCK_DGRAM:
                    found.append(connection.laddr)
    return found


@pytest.mark.parametrize("dashboard", [False, True])
def test_a_web_page_is_served_only_with_a_dashboard(
    dashboard: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paths, before = write_disks(tmp_path / "in", [100]), set(list_listening_addresses())
    seen: list[tuple[str, int]] = []
    pages: list[bytes] = []

    def look(_: str, share: float) -> None:
        seen.extend(set(list_listening_addresses()) - before)
        for word in capsys.readouterr().err.split():
            if word.startswith("http://127.0.0.1:"):
                pages.append(urlopen(word).read())

    assert flatten_files(paths, tmp_path / "out", workers=1, dashboard=dashboard, progress=look).good
    assert len(seen) == 3 + dashboard  # the scheduler, the worker, and the process that watches the worker
    assert [b"Dask" in page for page in pages] == [True] * dashboard


def list_workers() -> list[psutil.Process]:
    """Return the worker processes of this process's local cluster."""
    found = []
    for process in psutil.Process().children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            if "spawn_main" in " ".join(process.cmdline()):
                found.append(process)
    return found


@pytest.mark.slow
def test_a_process_that_dies_costs_one_mesh_at_most(tmp_path: Path) -> None:
    paths, out = write_disks(tmp_path / "in", [200 + 10 * k for k in range(18)]), tmp_path / "out"
    faces = [len(read_mesh(path)[1]) for path in paths]
    method = Hostile(faces[3], faces[7], faces[11], faces[15], str(tmp_path / "flag"), 0.05)
    before, others = list_listening_addresses(), set(list_workers())
    environment = dict(os.environ)
    seen: list[tuple[str, int]] = []
    threads: set[str | None] = set()

    def look(_: str, share: float) -> None:
        assert {row["outcome"] for row in read_results_table(out)} <= {"waiting", *ends}
        if share == 1 / len(paths):
            seen.extend(set(list_listening_addresses()) - set(before))
            for worker in list_workers():
                with suppress(psutil.NoSuchProcess):  # the worker has died in the meantime
                    environ = worker.environ()
                    threads.update(environ.get(n) for n in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"))
        if share == 2 / len(paths):
            with suppress(psutil.NoSuchProcess, KeyError):
                (set(list_workers()) - others).pop().kill()

    ends = {"valid", "died", "out of memory", "failed"}
    done = flatten_files(paths, out, workers=2, method=method, memory="500 MB", progress=look)
    by_outcome = {end: [k for k, row in enumerate(done.rows) if row.outcome == end] for end in ends}
    assert by_outcome == {
        "died": [3],
        "out of memory": [11],
        "failed": [15],
        "valid": [k for k in range(18) if k not in (3, 11, 15)],
    }
    assert "alone" in done.rows[3].message
    assert done.rows[15].message == "ZeroDivisionError: a mistake in the program"
    assert (tmp_path / "flag").exists()  # a worker process died once, and the second attempt succeeded
    assert len(seen) >= 3  # the scheduler and the processes that watch the two workers
    assert {address.ip for address in seen} == {"127.0.0.1"}
    assert threads == {"1"}
    assert dict(os.environ) == environment
    assert set(list_listening_addresses()) <= set(before)
    assert {path.name for path in out.rglob("*")} == {
        *(f"{k}.obj" for k in by_outcome["valid"]),
        *("results.csv", ".results.lock"),
        *(path.name for path in out.glob("results.parquet")),
    }
    assert flatten_files(paths, out, workers=1, method=method, memory="500 MB", progress=False).done == 0


@pytest.mark.slow
def test_a_mesh_is_not_blamed_for_a_single_death(tmp_path: Path, monkeypatch) -> None:
    # with this timeout, Dask gives up a worker that dies, and the batch has to start another worker
    monkeypatch.setitem(clusters.DASK_SETTINGS, "distributed.deploy.lost-worker-timeout", "1ms")
    paths = write_disks(tmp_path / "in", [200, 220, 240])
    faces = [len(read_mesh(path)[1]) for path in paths]
    method = Hostile(aborts=faces[0], aborts_once=faces[1], flag=str(tmp_path / "flag"))
    done = flatten_files(paths, tmp_path / "out", workers=1, method=method, progress=False)
    assert [row.outcome for row in done.rows] == ["died", "valid", "valid"]
    assert (tmp_path / "flag").exists()


def test_a_batch_warns_while_it_waits_for_workers(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(running, "PATIENCE", 0.2)
    paths = write_disks(tmp_path / "in", [200])
    options = {"host": "127.0.0.1", "dashboard_address": "127.0.0.1:0", "silence_logs": 50}
    with distributed.LocalCluster(n_workers=0, threads_per_worker=1, **options) as cluster:

        def show(message: Warning | str, *_: object, **__: object) -> None:
            if "no workers: the batch waits" in str(message):
                cluster.scale(1)

        with warnings.catch_warnings():
            warnings.simplefilter("always")
            warnings.showwarning = show  # without the warning, the batch would wait for a worker forever
            done = flatten_files(paths, tmp_path / "out", scheduler=cluster.scheduler_address, progress=False)
    assert done.good


def command(*arguments: object, entry: list[str] = ENTRY, **options: object) -> subprocess.Popen[str]:
    places = (str(ROOT), str(ROOT / "tests"), os.environ.get("PYTHONPATH", ""))
    return subprocess.Popen(
        [*entry, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(places)},
        **options,
    )


def wait_for(condition: Callable[[], bool], seconds: float = 300) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_finished_results_count_even_if_the_run_was_killed(tmp_path: Path) -> None:
    paths, out = write_disks(tmp_path / "in", [100] * 5), tmp_path / "out"
    settings = Settings("unwrap", resolve_method("lscm"), "obj")
    found = places.find_inputs([str(tmp_path / "in")], str(out))

    def killed_after(number: int) -> None:
        # the exception simulates the death of the run
        with pytest.raises(ZeroDivisionError), Table(str(out)) as table:
            for task in _plan_tasks(found, table, settings, retry=False, force=False)[:number]:
                run_task(task)
            raise ZeroDivisionError

    killed_after(2)
    before = snapshot(out)
    assert len(before) == len(list_recorded_maps(out)) == 2
    killed_after(1)  # interrupt the resumed run as well
    rest = flatten_files(tmp_path / "in", out, method="lscm", workers=1, progress=False)
    assert (rest.good, rest.done, len(rest.rows)) == (True, len(paths) - 3, len(paths))
    after = snapshot(out)
    assert all(after[name] == place for name, place in before.items())
    assert [path.name for path in out.glob(".*")] == [".results.lock"]


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="needs /proc")
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_an_interrupted_batch_resumes(how: int, scheduler: str, tmp_path: Path) -> None:
    # files are sorted as 0, 1, 10, ..., 13, 2, ...
    sizes, flag = [600] * 5 + [900] * 5 + [600] * 4, tmp_path / "go on"
    count, waiting = len(sizes), Hostile(waits=1500, flag=str(flag))
    write_disks(tmp_path / "in", sizes)
    out = tmp_path / "out"
    script = tmp_path / "waiting.py"
    script.write_text(WAITING.replace("FLAG", str(flag)))
    process = command(
        *(tmp_path / "in", "-o", out, "--workers", 2),
        entry=[sys.executable, str(script), "batch"],
        # a shell script that runs the tests in the background ignores Ctrl-C
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    done: list[int] = [0]

    def enough() -> bool:
        if (out / "results.csv").exists():
            rows = read_results_table(out)
            assert len(rows) == count
            done.append(sum(row["outcome"] != "waiting" for row in rows))
            assert done[-1] >= done[-2]
        return 3 <= len(snapshot(out)) == len(list_recorded_maps(out))

    wait_for(enough)
    process.send_signal(how)
    _, message = process.communicate(timeout=500)
    wait_for(lambda: not list_session_processes(process.pid))
    if how == signal.SIGINT:
        assert process.returncode == 130
        assert message.splitlines() == ["igl-linabf: interrupted"]
        assert not list(out.glob(".igl_linabf-*"))
    before = snapshot(out)
    assert 3 <= len(before) < count
    for name in before:
        read_texture(out / name)  # raises an error if the map is incomplete
    assert len(read_results_table(out)) == count
    known = list_recorded_maps(out)
    assert known <= set(before)
    # each of the two workers may have been interrupted before it listed its map
    assert len(known) >= len(before) - 2
    flag.touch()
    rest = flatten_files(tmp_path / "in", out, method=waiting, scheduler=scheduler, progress=False)
    assert rest.good
    assert rest.done == count - len(known)
    after = snapshot(out)
    assert all(after[name] == before[name] for name in known)
    assert not list(out.glob(".igl_linabf-*"))
    if how == signal.SIGKILL:
        twin = tmp_path / "twin"
        for row in flatten_files(
            tmp_path / "in", twin, method=Hostile(), scheduler=scheduler, progress=False
        ).rows:
            assert (twin / row.output).read_bytes() == (out / row.output).read_bytes()


@pytest.mark.slow
def test_a_full_disk_ends_the_batch_which_can_be_resumed(scheduler: str, tmp_path: Path) -> None:
    import resource

    write_disks(tmp_path / "in", [100, 110, 3000, 120])
    out = tmp_path / "out"
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))  # noqa: E731
    process = command(tmp_path / "in", "-o", out, "--workers", 1, preexec_fn=limit)
    _, message = process.communicate(timeout=500)
    assert process.returncode == 2
    assert message.splitlines()[-1] == f"igl-linabf: {out}/2.obj: File too large"
    assert len(message.splitlines()) == 1
    assert "2.obj" not in snapshot(out)
    assert read_results_table(out)[2]["outcome"] == "waiting"
    assert flatten_files(tmp_path / "in", out, scheduler=scheduler, progress=False).good
    assert "2.obj" in snapshot(out)


def test_the_command_prints_a_summary(scheduler: str, tmp_path: Path) -> None:
    write_disks(tmp_path / "in", [100])
    process = command(
        tmp_path / "in/*.obj", "-o", tmp_path / "out", "--scheduler", scheduler, "--format", "ply"
    )
    printed, message = process.communicate(timeout=500)
    assert process.returncode == 0, message
    assert "dashboard" not in message
    assert printed.startswith("1 mesh: 1 valid\n1 done in ")
    assert igl.read_triangle_mesh(str(tmp_path / "out/0.ply"))[1].shape[1] == 3


def test_options_give_the_same_maps_as_flatten_and_unwrap(scheduler: str, tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    ball = igl.upsample(*igl.icosahedron(), 2)
    dome = igl.remove_unreferenced(ball[0], ball[1][ball[0][ball[1]].mean(axis=1)[:, 2] > -0.2])[:2]
    igl.writeOBJ(str(folder / "dome.obj"), *dome)
    options = {"how": "flatten", "boundary": "circle"}
    assert flatten_files(folder, tmp_path / "flat", scheduler=scheduler, progress=False, **options).good
    rim = read_texture(tmp_path / "flat/dome.obj")[0][igl.boundary_loop(dome[1])]
    radius = np.linalg.norm(rim - 0.5, axis=1)
    assert np.ptp(radius) < 1e-5 * radius.max()
    V, F = ball  # break the symmetry, because rounding would choose between equal cones
    V = V * [1.0, 1.1, 1.25] + 0.01 * np.sin(7 * V @ np.random.default_rng(0).normal(size=(3, 3)))
    igl.writeOBJ(str(folder / "ball.obj"), V, F)
    options = {"cones": Cones(8, angles="quarter"), "packing": Packing(resolution=256, padding=4)}
    assert flatten_files(folder, tmp_path / "coned", scheduler=scheduler, progress=False, **options).good
    written = read_texture(tmp_path / "coned/ball.obj")
    expected = unwrap(*read_mesh(folder / "ball.obj"), **options)
    assert all(np.allclose(a, b) for a, b in zip(written, (expected.TC, expected.FTC), strict=True))


def test_invalid_arguments_are_refused_before_the_computation(tmp_path: Path, monkeypatch) -> None:
    write_disks(tmp_path / "in", [100])
    (tmp_path / "empty").mkdir()
    out = tmp_path / "out"
    for options, message in (
        ({"format": "stl"}, "format is 'stl': use obj, ply, glb"),
        ({"method": "lscmm"}, "method is 'lscmm'"),
        ({"how": "fold"}, "how is 'fold'"),
        ({"how": "flatten", "charts": ChartOptions(keep_holes=True)}, "are not options of flatten"),
        ({"how": "flatten", "cones": 8}, "are not options of flatten"),
        ({"boundary": "circle"}, "charts have a free boundary"),
        ({"how": "flatten", "boundary": "star"}, "boundary is 'star'"),
        ({"how": "flatten", "boundary": "circle", "method": "lscm"}, "the method 'lscm'"),
        ({"cones": "many"}, "cones is 'many'"),
        ({"cones": [0, 1]}, r"cones is \[0, 1\]"),
        ({"cones": 8, "charts": ChartOptions(keep_holes=True)}, "not go together"),
        ({"charts": ChartOptions(hide=np.ones(9))}, "charts is ChartOptions.*without weights"),
        ({"charts": ChartOptions(labels=np.ones(9))}, "charts is ChartOptions.*without labels"),
        ({"charts": [[0, 1]]}, r"charts is \[\[0, 1\]\]"),
        ({"charts": ChartOptions(extend=True)}, "extend=True adds to given seams"),
        ({"packing": {"resolution": 0}}, "packing is {'resolution': 0}"),
        ({"memory": "much"}, "memory is 'much'"),
        ({"memory": 0}, "memory is 0"),
        ({"workers": 0}, "workers is 0"),
        ({"workers": 1, "scheduler": "tcp://127.0.0.1:1"}, "give one of the two"),
    ):
        with pytest.raises(ValueError, match=message):
            flatten_files(tmp_path / "in", out, **options)
    with pytest.raises(MeshError, match="holds no mesh file"):
        flatten_files(tmp_path / "empty", out)
    with pytest.raises(MeshError, match="holds no mesh file"):
        flatten_files(str(tmp_path / "in/*.png"), out)
    with pytest.raises(FileNotFoundError):
        flatten_files(tmp_path / "nowhere.obj", out)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ImportError, match=r"igl-linabf\[batch\]"):
        flatten_files(tmp_path / "in", out)
    assert not out.exists()


def test_formulas_in_a_table_are_quoted_and_read_back(tmp_path: Path) -> None:
    rows = [Row(input=f"/{i}", output=f"{start}1+1.obj", charts=i) for i, start in enumerate("=+-@'a")]
    with Table(str(tmp_path)) as table:
        table.plan_rows(rows)
    text = (tmp_path / "results.csv").read_text(encoding="utf-8")
    assert [line["output"][0] for line in csv.DictReader(text.splitlines())] == ["'"] * 5 + ["a"]
    with Table(str(tmp_path)) as table:
        assert [table.get_row(row.input) for row in rows] == rows
