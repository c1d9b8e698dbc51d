"""An FMU instance for FMPy that records Strings and ends a run as FMI defines.

FMPy records numbers. An FMU can end a run in a step from t to t + h:

    FMI 2.0   fmi2DoStep returns fmi2Discard and fmi2Terminated is true; values are then those at fmi2LastSuccessfulTime
    FMI 3.0   terminateSimulation is true; values are then those at lastSuccessfulTime

If the end is not stated, or is not between t and t + h, it is t, the end of the last completed step. FMPy itself
repeats a step that is discarded without a request to end the run. In FMI 3.0, it takes t + h as the end.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2LastSuccessfulTime, fmi2Terminated

from amb_cosim.cosim.fmu.bindings import DISCARD


class WatchedInstance:
    """An instance of FMPy with all its functions.

    Parameters
    ----------
    fmu
        The instance of FMPy.
    texts
        Value references of Strings.
    start_time
        Time of the initialisation (s).

    Attributes
    ----------
    seen
        Times (s) at which the Strings were read, with their values.
    """

    def __init__(self, fmu: Any, texts: Sequence[int], start_time: float) -> None:
        self._fmu, self._texts, self._end = fmu, list(texts), start_time
        self.seen: list[tuple[float, list[str]]] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._fmu, name)

    @property  # type: ignore[misc]
    def __class__(self) -> Any:
        """The class of FMPy's instance; FMPy uses it to choose the functions that set inputs."""
        return type(self._fmu)

    def exitInitializationMode(self) -> Any:
        """End the initialisation."""
        status = self._fmu.exitInitializationMode()
        self._see_texts()
        return status

    def doStep(self, currentCommunicationPoint: float, communicationStepSize: float) -> Any:
        """Make a step; if the FMU ends the run in this step, report the end of the run as the end of the step.

        Raises
        ------
        FMICallException
            If the step fails, or ends the run in FMI 2.0.
        RuntimeError
            If the step is not completed, and the FMU does not end the run.
        """
        begin, end = currentCommunicationPoint, currentCommunicationPoint + communicationStepSize
        self._end = end
        try:
            answer = self._fmu.doStep(begin, communicationStepSize)
        except FMICallException as error:
            if error.status == DISCARD:
                self._end = self._end_of_run(begin, end)
                self._see_texts()
            raise
        if isinstance(answer, tuple):
            event, ends, early, reached = answer
            if early and not ends:
                raise RuntimeError(f"it returned early from the step at {begin:.9g} s, which is not allowed")
            self._end = _within(reached, begin, end) if ends else end
            answer = event, ends, self._end < end, self._end
        self._see_texts()
        return answer

    def getRealStatus(self, kind: int) -> float:
        """Return the time at which a discarded step ended the run (s)."""
        return self._end

    def _end_of_run(self, begin: float, end: float) -> float:
        terminated, reached = False, begin
        with suppress(FMICallException):  # an FMU may be unable to answer
            terminated = bool(self._fmu.getBooleanStatus(fmi2Terminated))
        if not terminated:
            raise RuntimeError(f"it discarded the step at {begin:.9g} s")
        with suppress(FMICallException):
            reached = float(self._fmu.getRealStatus(fmi2LastSuccessfulTime))
        return _within(reached, begin, end)

    def _see_texts(self) -> None:
        if self._texts:
            values = self._fmu.getString(self._texts)
            texts = [v.decode("utf-8", "replace") if isinstance(v, bytes) else str(v) for v in values]
            self.seen.append((self._end, texts))


def _within(reached: float, begin: float, end: float) -> float:
    return reached if begin <= reached <= end else begin
