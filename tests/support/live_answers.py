"""What a session of the live rig answered."""

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Answers:
    """What a session answered; `rows` are all samples it showed, time first, those that were taken back left out."""

    all: list[dict[str, Any]]

    def of(self, kind: str) -> list[dict[str, Any]]:
        return [answer for answer in self.all if answer["type"] == kind]

    @property
    def watched(self) -> list[str]:
        return self.of("ready")[0]["watched"]

    @property
    def rows(self) -> np.ndarray:
        pieces: list[np.ndarray] = []
        for frame in self.of("frame"):
            if frame["anew"]:
                retained = np.concatenate([np.empty((0, len(self.watched) + 1)), *pieces])
                pieces = [retained[: frame["from"]]]
            pieces.append(np.reshape(frame["rows"], (-1, len(self.watched) + 1)))
        return np.concatenate(pieces)

    def column(self, name: str) -> np.ndarray:
        return self.rows[:, 1 + self.watched.index(name)]
