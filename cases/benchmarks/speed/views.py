"""Tables of speeds now and before."""

from ..view import View

COLUMNS = {
    "what": "{case}",
    "now": "{now:.3g} {unit}",
    "before": "{before:.3g}",
    "ratio": "{ratio:.2f}",
    "asked": "{asked:.2f}",
}
VIEWS = {
    "runs": View(
        r"(first|warm) start.*|accordion.*|pancake, [aN].*",
        COLUMNS | {"results differ by": "{error:.0e}"},
    ),
    "shells": View(r"shell, .*", COLUMNS),
    "near": View(r"near field.*", COLUMNS),
    "dense": View(
        r"limit.*|dense layer.*|(patch blocks|coarse image|preconditioner).*",
        COLUMNS | {"of the limit": "{of limit:.0%}"},
    ),
    "far": View(r"H2.*|FMM3D.*|solve.*", COLUMNS),
}
