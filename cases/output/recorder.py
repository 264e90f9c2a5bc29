"""A recorder that ignores everything; the others override what concerns them."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from coupling import AcceptedStep, Iteration, Outcome, Rejection, Snapshot


class Silent:
    """Base of all recorders of a run folder."""

    def on_start(self, step: AcceptedStep) -> None:
        pass

    def on_iteration(self, iteration: Iteration) -> None:
        pass

    def on_accepted(self, step: AcceptedStep) -> None:
        pass

    def on_rejected(self, rejection: Rejection) -> None:
        pass

    def on_note(self, step: int, text: str) -> None:
        pass

    def on_checkpoint(self, snapshot: Snapshot) -> None:
        pass

    def close(self, outcome: Outcome) -> None:
        pass
