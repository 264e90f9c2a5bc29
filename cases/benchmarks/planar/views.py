"""Tables of the planar benchmark."""

from ..view import View

VIEWS = {
    "rates": View(
        r"(?P<what>Stokes traction|potential), (?P<n>\d+) segments",
        {"": "{what}", "expected rate": "{expected rate}"},
        ("{n} segments: error (rate)", "{error:.1e} ({rate:.2f})"),
    ),
    "identities": View(
        r"self integrals|K c = -c/2",
        {
            "": "{case}",
            "Stokes flow": "{error:.0e}",
            "potential flow": "{error of potential flow:.0e}",
        },
    ),
    "gaps": View(
        r"squeeze film, H = (?P<H>\S+), .*",
        {
            "H": "{H}",
            "element / gap": "{element/gap:.3g}",
            "load error": "{error:.1e}",
            "with plain 4-point Gauss": "{error, plain 4 points:.0%}",
        },
    ),
    "exponents": View(
        r"exponent of (?P<what>.+)",
        {"": "{what}", "exponent": "{exponent:.3f}", "theory": "{theory}"},
    ),
    "load": View(
        r"load functional, (?P<n>\d+) elements",
        {
            "elements": "{n}",
            "load error, k = 1": "{error:.1e}",
            "rate, k = 1": "{rate, k=1:.2f}",
            "rate, k = 3": "{rate, k=3:.2f}",
            "pressure error": "{error of p:.1e}",
            "its rate": "{rate of p:.2f}",
            "k = 2 over k = 1": "{load, k=2 over k=1:.0e}",
        },
    ),
    "pancakes": View(
        r"potential pancake, (?P<what>.+)",
        {
            "resolution": "{what}",
            "H2 error": "{error:.1e}",
            "rate, t <= 0.75": "{rate, t <= 0.75:.2f}",
            "rate, t <= 3": "{rate, t <= 3:.2f}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "folds": View(
        r"potential fold, eps = (?P<eps>\S+), (?P<n>\d+) elements",
        {
            "rigidity": "{eps}",
            "elements": "{n}",
            "H2 error": "{error:.1e}",
            "rate": "{rate, t <= 0.3:.2f}",
            "rate of the position": "{rate, position:.2f}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "runs": View(
        r"(?:pancake|deflation|fold), (?!V/V0).*",
        {
            "run": "{case}",
            "seconds": "{seconds:.3g}",
            "result": "`{result}`",
            "t": "{t:.4g}",
            "V/V0": "{V/V0:.3g}",
            "smallest gap": "{min gap:.3g}",
            "rejected": "{rejected}",
            "error": "{error:.0e} ({error_kind})",
        },
    ),
    "pancake": View(
        r"pancake, lambda = 1",
        {
            "pressure at the end": "{pressure:.4g}",
            "error": "{error:.0e} ({error_kind})",
            "stretch": "{stretch}",
        },
    ),
    "contact": View(
        r"contact, (?P<what>.+)",
        {
            "varied": "{what}",
            "result": "`{result}`",
            "t": "{t:.5g}",
            "smallest gap": "{min gap:.2g}",
            "seconds": "{seconds:.3g}",
        },
    ),
    "opening": View(
        r"fold, V/V0 = (?P<v>.+)",
        {
            "V/V0": "{v}",
            "Stokes flow: chamber, first, last folds": (
                "{chamber:.2f}, {first folds:.2f}, {last folds:.2f}"
            ),
            "uniform pressure": (
                "{chamber, uniform:.2f}, {first folds, uniform:.2f}, {last folds, uniform:.2f}"
            ),
        },
    ),
    "heights": View(
        r"(?P<width>width \d+), V/V0 = (?P<v>.+)",
        {
            "pancake": "{width}",
            "V/V0": "{v}",
            "Stokes flow": "{height:.3g}",
            "uniform pressure": "{height, uniform:.3g}",
        },
    ),
}
