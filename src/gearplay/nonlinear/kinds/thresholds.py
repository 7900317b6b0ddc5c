"""The ten thresholds of `classify`, each with its unit, its meaning and how its value was found.

"Seen" refers to the 1000 synthetic responses of ``tests/responses.py`` with seeds 100 to 104. The error rate in
``docs/nonlinear.md`` was measured with other seeds.
"""

from typing import Final

SPREAD: Final = 1.5
"""[resolution] Standard deviation about a repetition up to which a section repeats; single samples may deviate five times as far.
Noise as large as the resolution gives 1 +- 0.06 in 300 periods, and a resolution is an estimate."""

REPEATS: Final = 8
"""[1] Cycles that a record must hold. With 8 the mean of the cycle takes up an eighth of the noise; 3 to 8 give undecided."""

CLEAR: Final = 4.0
"""[1] Factor by which a motion must exceed what blurs it: its deviation from repetition the resolution, and the distance of
arbitrary states that of neighbours. All settled motions seen exceed both; noise of the resolution reaches 1.5."""

LINE_RATIO: Final = 3.0
"""[1] Linear amplitude change of the spectral lines, relative to what changing lines leave unexplained, from which a regular
motion has not settled. Seen: 0.6 at most on 196 of 200 tori. See `LINE_SHARE`."""

LINE_SHARE: Final = 0.006
"""[1] The same change relative to the motion. Both must be reached; half of both gives undecided, since combinations of the
frequencies of a torus may turn more slowly than the record. A change above `SLOW` needs half the ratio: a fast decay is far from
linear. Seen on tori with a ratio above 1.5: 0.01 at most; on decays: 0.0035 at least, 0.006 in 299 of 300."""

SLOW: Final = 0.05
"""[1] Share of a regular motion's variance that turns less than twice in the record, above which it may be a slow beat or a
drift: undecided. Seen on tori: 0.014 at most; of oscillations with 0.3 to 1.5 turns: 0.98 at least."""

BLOCK_STEP: Final = 9.0
"""[1] Student's t of the best step or line between 16 blocks of an irregular motion, from which its statistics have changed.
Blocks without memory reach it in one of 2e5 features; chaos seen: 6.7 at most; jumps to or from chaos: 12 at least."""

REGULAR: Final = 0.4
"""[1] Loss of closeness and K of the 0-1 test up to which each is a vote for regular motion. Seen on tori: loss 0.28 and K
0.35 at most."""

CHAOTIC: Final = 0.7
"""[1] Loss of closeness and K from which each is a vote for chaos, and largest forecast error of chaos as against noise.
Observed in chaos: loss 0.87, K 0.84 in 398 of 400 records, forecast error 0.65 in 396; noise has an error of 0.80 at least."""

ERRORS: Final = 3.0
"""[standard error] Largest exponent that is still zero: exceeded by chance once in 400 records."""
