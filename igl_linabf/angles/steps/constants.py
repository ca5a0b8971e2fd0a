"""Constants that several modules of steps share."""

ROUGH_RTOL = 0.1  # relative residual of conjugate gradients in a step that is followed by other steps
CORRECTABLE = 0.12  # conformal corrections start below this residual
CORRECTABLE_PRESCRIBED = 0.25  # replaces CORRECTABLE if angle sums or turnings are prescribed
