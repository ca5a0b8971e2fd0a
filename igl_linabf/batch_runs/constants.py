"""The constants of batches: patience with processes, memory of workers, work that is handed out, writing."""

# -- Processes

# Seconds until a scheduler answers, or without a result until it is asked for its workers. Less gives a
# busy scheduler up; more makes the user wait where there is none. tests/batch_runs/test_running.py
PATIENCE = 30

# Seconds after which no worker of our own is thought to come back. Less ends a batch whose workers start
# slowly; more hangs where none can start. tests/batch_runs/test_running.py
NO_WORKER = 600

# Milliseconds between two looks whether a worker is gone for good. Less takes time from the scheduler; more
# leaves a core idle as long. tests/batch_runs/test_running.py
MENDING_INTERVAL = 1000

# Deaths of a process that has a mesh alone, until the mesh is to blame. Fewer blame meshes whose process
# something else has killed; more repeat a crash as often. tests/batch_runs/test_running.py
DEATHS_ALONE = 3

# -- Memory

# Bytes that a worker takes at most before it has a mesh. Less ends workers whose mesh keeps to its limit;
# more lets a mesh take more than its limit. tests/batch_runs/test_running.py
WORKER_MEMORY = 2**29

# Share of a worker's memory at which Dask ends it: Dask's own default. Less wastes what was allowed; more
# lets the system end processes first, and any of them. tests/batch_runs/test_running.py
TERMINATE = 0.95

# -- Work and results

# Meshes that are handed out ahead for each thread. Fewer leave threads idle between meshes; more are lost
# with a scheduler. benchmarks/batch.py
AHEAD = 8

# Meshes that are handed out ahead at least, whatever the threads. Fewer leave workers that join later
# without work; more are lost with a scheduler. benchmarks/batch.py
AHEAD_AT_LEAST = 64

# Pause between two writings of the table, over the time that one takes. Less slows the batch down by more
# than a fiftieth; more leaves results to the journals for longer. benchmarks/batch.py
WRITING_PAUSE = 50
