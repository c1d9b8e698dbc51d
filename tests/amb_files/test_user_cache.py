"""A cache writable by other users is not used, because it holds machine code."""

import os

import pytest

from amb_files import user_cache
from amb_files.user_cache import is_private
from tests.support.messages import assert_names

pytestmark = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="needs owners of files, as POSIX has them")


@pytest.fixture
def home(tmp_path, monkeypatch):
    folder = tmp_path / "home" / "cache"
    folder.mkdir(parents=True, mode=0o700)
    monkeypatch.setattr("platformdirs.user_cache_path", lambda name, **_: folder / name)
    user_cache._of_this_process.cache_clear()
    yield folder
    user_cache._of_this_process.cache_clear()


def test_the_cache_is_a_private_folder_of_the_user(home):
    result = user_cache.user_cache()
    assert result == home / "amb-cosim"
    assert result.stat().st_mode & 0o077 == 0
    assert is_private(result)


@pytest.mark.parametrize("mode", [0o777, 0o702, 0o1777])
def test_a_folder_that_others_can_write_to_is_not_used(home, mode, caplog):
    (home / "amb-cosim").mkdir()
    (home / "amb-cosim").chmod(mode)
    first, second = user_cache.user_cache(), user_cache.user_cache()
    assert home not in first.parents
    assert first == second
    (record,) = caplog.records
    assert_names(record.message, str(home / "amb-cosim"))


def test_a_folder_that_others_could_replace_is_not_used(home):
    user_cache.user_cache()
    home.chmod(0o777)
    assert not is_private(home / "amb-cosim")
    home.chmod(0o1777)  # as /tmp
    assert is_private(home / "amb-cosim")


def test_a_folder_of_another_user_is_not_used(home, monkeypatch):
    user_cache.user_cache()
    other = os.geteuid() + 1
    monkeypatch.setattr(os, "geteuid", lambda: other)
    assert not is_private(home / "amb-cosim")


def test_a_group_with_the_user_as_only_member_is_private(home, monkeypatch):
    result = user_cache.user_cache()
    result.chmod(0o770)
    monkeypatch.setattr(user_cache, "_has_single_member", lambda _: True)
    assert is_private(result)
    monkeypatch.setattr(user_cache, "_has_single_member", lambda _: False)
    assert not is_private(result)
