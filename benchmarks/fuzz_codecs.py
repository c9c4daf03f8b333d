"""Feed damaged frames to both ends of every codec, and print what held.

`python benchmarks/fuzz_codecs.py [--frames 1000000] [--codec NAME] [--seed N]`. What is checked
stands at the head of tests/firmware_protocol/fuzz_rounds.py. Ends with 1 where something did not
hold, and with the seed that repeats it.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "firmware_protocol"))
from fuzz_rounds import CODECS, Tally, Violation, grown_bytes, registered, run
from fuzzing import FuzzCase

BLOCK_FRAMES = 10_000
"""Each block of frames is a machine and a seed of its own, so that a failure repeats quickly."""
WEIGHED_FRAMES = 10_000
HEAD = f"{'':<20}{'frames':>9}{'MB':>8}{'resyncs':>9}{'worst':>7}{'grown':>8}"


def fuzz(case: FuzzCase, seed: int, frames: int) -> bool:
    """Run one end of a codec, print its row, and tell whether everything held."""
    began_s = time.perf_counter()
    tally, block_seed = Tally(), seed
    try:
        weighed = min(WEIGHED_FRAMES, frames)
        grown = grown_bytes(case, seed, weighed // 2)
        for block, at in enumerate(range(0, frames, BLOCK_FRAMES)):
            block_seed = seed + block
            tally.add(run(case, block_seed, min(BLOCK_FRAMES, frames - at)))
    except Violation as violation:
        codec = case.name.partition(" ")[0]
        print(f"{case.name:<20}FAILED at {violation}")
        print(f"  repeat: --codec {codec} --seed {block_seed} --frames {violation.frames}")
        return False
    print(
        f"{case.name:<20}{tally.frames:>9}{tally.fed_bytes / 1e6:>8.1f}{tally.resyncs:>9}"
        f"{tally.most_good_frames:>7}{grown:>8}"
        f"{time.perf_counter() - began_s:>8.1f} s",
        flush=True,
    )
    return True


def main(argv: list[str] | None = None) -> int:
    """Fuzz the codecs that are asked for, or all of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--frames", type=int, default=1_000_000, help="for each end of a codec")
    parser.add_argument("--codec", choices=CODECS, help="this one alone")
    parser.add_argument("--seed", type=int, default=1, help="the same seed, the same frames")
    options = parser.parse_args(argv)
    print(HEAD)
    cases = registered((options.codec,) if options.codec else CODECS)
    held = [fuzz(case, options.seed, options.frames) for case in cases]
    print("worst: good frames until one was heard; grown: bytes")
    return 0 if all(held) else 1


if __name__ == "__main__":
    sys.exit(main())
