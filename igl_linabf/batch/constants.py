"""Constants that several modules of batches use."""

PATIENCE = 30  # seconds to wait for a scheduler, or for a result before the workers are checked
