"""Tables of the trials."""

from ..view import View

PROMISE = {
    "promise": "{promise}",
    "tried": "{tried}",
    "held": "{held}",
    "broken, announced": "{broken}",
    "silent": "{silent}",
}
VIEWS = {
    "measured": View(
        r"(matrices|shells): (?P<promise>.+)", {**PROMISE, "worst ratio": "{worst ratio:.2g}"}
    ),
    "estimated": View(
        r"flows: (?P<promise>.+)",
        {
            **PROMISE,
            "worst ratio": "{worst ratio:.2g}",
            "effectivity 0, 5, 50, 95, 100%": (
                "{effectivity 0%:.2f}, {effectivity 5%:.2f}, {effectivity 50%:.2f}, "
                "{effectivity 95%:.2f}, {effectivity 100%:.2f}"
            ),
            "least estimate over error at the end": "{least left:.2f}",
            "violated where the mesh resolves": "{violated there} of {resolved}",
        },
    ),
    "told": View(r"(folders|scenes): (?P<promise>.+)", PROMISE),
}
