"""Numbers of a sine and cosine that compilers vectorise: turned into the first quadrant, then a polynomial.

The C library's are called angle by angle, which takes longer than all else. The polynomials for |r| <= pi/4
and pi/2 in parts are published: of double precision those of FreeBSD's msun (k_sin.c, k_cos.c, e_rem_pio2.c),
of single precision those of Cephes (sinf.c, cosf.c).
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SineCosine:
    """Numbers for one precision.

    Parameters
    ----------
    parts
        pi/2 in parts, the first two of so few digits that their products with the number of quarter turns are
        exact.
    largest
        Angles up to which that holds, rad; beyond it the C library's are called.
    sine, cosine
        Coefficients s and c of r + r z (s0 + s1 z + ..) and 1 - z/2 + z z (c0 + c1 z + ..), z = r r.
    """

    parts: tuple[float, float, float]
    largest: float
    sine: tuple[float, ...]
    cosine: tuple[float, ...]


DOUBLE = SineCosine(
    (1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21),
    1e6,
    (
        -1.66666666666666324348e-01,
        8.33333333332248946124e-03,
        -1.98412698298579493134e-04,
        2.75573137070700676789e-06,
        -2.50507602534068634195e-08,
        1.58969099521155010221e-10,
    ),
    (
        4.16666666666666019037e-02,
        -1.38888888888741095749e-03,
        2.48015872894767294178e-05,
        -2.75573143513906633035e-07,
        2.08757232129817482790e-09,
        -1.13596475577881948265e-11,
    ),
)
FLOAT = SineCosine(
    (1.5703125, 4.837512969970703125e-4, 7.54978995489188216e-8),
    8e3,
    (-1.6666654611e-1, 8.3321608736e-3, -1.9515295891e-4),
    (4.166664568298827e-2, -1.388731625493765e-3, 2.443315711809948e-5),
)
