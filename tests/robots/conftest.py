"""What the tests of robots share."""

import pytest

pytest.register_assert_rewrite("agentrob.robots.contract")
