"""A run's history kept in memory."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from coupling import AcceptedStep, Rejection, State

from ..output.recorder import Silent


@dataclass
class RecordedHistory(Silent):
    """Keeps rows, states and rejections of a run in memory."""

    rows: list[dict[str, float]] = field(default_factory=list)
    states: list[State] = field(default_factory=list)
    rejections: list[Rejection] = field(default_factory=list)

    def on_start(self, step: AcceptedStep) -> None:
        self.on_accepted(step)

    def on_accepted(self, step: AcceptedStep) -> None:
        self.rows.append(dict(step.row))
        self.states.append(step.state)

    def on_rejected(self, rejection: Rejection) -> None:
        self.rejections.append(rejection)

    def column(self, name: str) -> np.ndarray:
        return np.array([row[name] for row in self.rows])
