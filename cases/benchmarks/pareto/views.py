"""Tables of error against seconds: where the defaults lie."""

from ..view import View

VIEWS = {
    "defaults": View(
        r".*",
        {
            "problem": "{problem}",
            "default": "{family}, {setting}",
            "error": "{error:.1e}",
            "seconds": "{seconds:.2g}",
            "against": "{reference}",
        },
        only={"default": True},
    ),
}
