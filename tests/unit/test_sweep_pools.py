"""Addresses of schedulers that are none are refused before dask sees them."""

import pytest

from fibermelt.errors import ConfigError
from fibermelt.study.sweep.pools import open_pool


@pytest.mark.parametrize("address", ["foo://x", "tcp://", "tcp://host", "tcp://host:port"])
def test_what_is_no_address_is_refused(tmp_path, address):
    with (
        pytest.raises(ConfigError, match=f"--scheduler {address}: is no address such as tcp://"),
        open_pool(None, address, tmp_path),
    ):
        pass


@pytest.mark.parametrize(
    ("held", "said"),
    [
        ("garbage", "holds no address"),
        ("[]", "holds no address"),
        ('"text"', "holds no address"),
        ("{}", "holds no address"),
        ('{"address": 5}', "is no address such as tcp://host:8786, nor is 5 in it"),
    ],
)
def test_a_file_without_an_address_is_refused(tmp_path, held, said):
    file = tmp_path / "scheduler.json"
    file.write_text(held)
    with pytest.raises(ConfigError, match=said), open_pool(None, str(file), tmp_path / "results"):
        pass
