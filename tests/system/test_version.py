"""The version is derived from git tags; trees and clones without tags have a version and build."""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow  # needs hatch-vcs

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LAST_RELEASE = PROJECT["tool"]["hatch"]["version"]["fallback-version"]


@pytest.fixture
def tree(tmp_path):
    """A source tree as far as the version needs it."""
    pytest.importorskip("hatch_vcs")
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def git(tree, *arguments):
    command = ["git", "-c", "user.name=A", "-c", "user.email=a@example.org", *arguments]
    subprocess.run(command, cwd=tree, check=True, capture_output=True)


def version(tree):
    command = [sys.executable, "-m", "hatchling", "version"]
    return subprocess.run(command, cwd=tree, check=True, capture_output=True, text=True).stdout.strip()


def test_a_tree_without_git_has_the_last_release(tree):
    assert version(tree) == LAST_RELEASE


def test_a_clone_without_tags_comes_after_the_last_release(tree):
    git(tree, "init", "-q")
    git(tree, "add", ".")
    git(tree, "commit", "-qm", "First")
    major, minor, patch = LAST_RELEASE.split(".")
    assert re.fullmatch(rf"{major}\.{minor}\.{int(patch) + 1}\.dev\d+", version(tree))


def test_commits_after_a_tag_are_development_versions_of_the_next(tree):
    git(tree, "init", "-q")
    git(tree, "add", ".")
    git(tree, "commit", "-qm", "First")
    git(tree, "tag", "v1.2.3")
    assert version(tree) == "1.2.3"
    git(tree, "commit", "-qm", "Second", "--allow-empty")
    assert version(tree) == version(tree) == "1.2.4.dev1", "the same commit has the same version"


def test_citation_and_changes_name_the_last_release():
    assert f"\nversion: {LAST_RELEASE}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\n## {LAST_RELEASE}\n" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
