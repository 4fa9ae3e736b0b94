"""Ringdown: from a recording of a wobbling soft body to a calibrated model of it."""

import os

__version__ = "0.1.0"

# Many small products: a second BLAS thread mostly waits, and doubles the time on two cores. It
# counts where numpy is not loaded yet, and whoever sets it otherwise is heeded.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
