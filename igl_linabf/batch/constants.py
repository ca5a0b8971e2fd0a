"""Define a constant that several modules of batches use."""

PATIENCE = 30  # seconds to wait for a scheduler, and for a result before checking that workers exist
