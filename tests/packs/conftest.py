"""The tests of packs use the command line as those of the orchestrator do."""

from tests.orchestrator.conftest import refuses, runner

__all__ = ["refuses", "runner"]
