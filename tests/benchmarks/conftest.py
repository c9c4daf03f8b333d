"""The tests of benchmarks import them as they import each other: by their names alone."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
