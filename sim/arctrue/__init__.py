"""ArcTrue: the true angle of a rotary table from two read heads."""

import os

# The fits multiply blocks of some 40 columns: a second thread of the linear algebra brings
# nothing there, and where another program wants the core too, waiting for it takes ten times as
# long as the work. numpy reads this when it is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
