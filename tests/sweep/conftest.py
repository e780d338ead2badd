import pytest
from tests.sweep.four_bowls import BOWLS


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "bowls.toml"
    path.write_text(BOWLS)
    return path
