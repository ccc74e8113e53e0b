"""The master: couples FMUs, finds flutter boundaries, records and reports. It knows FMUs only, no physics."""

import os

# the matrices of the damping fit are tiny: threads of the linear algebra library would only burn CPU beside the march
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
