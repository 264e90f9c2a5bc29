"""Tables of the coupling benchmark."""

from ..view import View

STATE = {"scene": "`{scene}`", "t": "{t}", "m": "{mass_ratio}", "dt": "{dt:g}"}
VIEWS = {
    "contraction": View(
        r"(?P<scene>\S+), t = (?P<t>\S+): contraction",
        STATE
        | {
            "spectral radius": "{spectral radius:.3g}",
            "measured ratio off by": "{error:.0e}",
            "formula over radius": "{a priori / radius:.2f}",
        },
    ),
    "schemes": View(
        r"(?P<scene>\S+), t = (?P<t>\S+): (?P<scheme>(?!contraction).+)",
        STATE,
        ("{scheme}", "{assemblies/step:.1f} / {seconds:.2g} / {error:.0e}"),
    ),
    "kept": View(
        r"operators kept: (?P<what>.+)",
        {
            "run": "{what}",
            "assemblies": "{assemblies}",
            "without keeping": "{of}",
            "seconds over those": "{ratio:.2f}",
            "difference": "{error:.0e}",
        },
    ),
    "time": View(
        r"(?P<kind>backward-euler|bdf2): (?P<n>\d+) steps",
        {"integrator": "`{kind}`"},
        ("{n} steps: error (rate)", "{error:.1e} ({rate:.2f})"),
    ),
    "space": View(
        r"space: (?P<n>\d+) elements",
        {"norm": "{norm}"},
        ("{n} elements: error (rate)", "{error:.1e} ({rate:.2f})"),
    ),
    "capsule": View(
        r"capsule, lambda = (?P<ratio>\S+), nu = (?P<nu>\S+), (?P<mesh>.+)",
        {
            "lambda": "{ratio}",
            "nu": "{nu}",
            "mesh": "{mesh}",
            "deformation": "{D:.5f}",
            "theory": "{theory:.5f}",
            "error": "{error:.2%}",
            "seconds": "{seconds:.2g}",
        },
    ),
    "stress": View(
        r"stress: (?P<what>.+)",
        {
            "run": "{what}",
            "result": "{result}",
            "t": "{t:.4g} of {of:.4g}",
            "rejected": "{rejected}",
            "volume error": "{error:.0e}",
            "damaged files": "{damaged files}",
        },
    ),
    "killed": View(
        r"kill -9 and resume: (?P<what>.+)",
        {
            "run": "{what}",
            "rows": "{rows}",
            "when killed": "{rows when killed}",
            "share that differs after resuming": "{error:g}",
        },
    ),
}
