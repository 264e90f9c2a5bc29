"""Settings of the whole suite, made before numpy and numba load."""

import os

# one BLAS thread: small matrices, and kernels bring their own threads
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
