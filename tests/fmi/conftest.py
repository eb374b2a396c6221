"""What the tests of the FMUs share."""

import pytest


@pytest.fixture(params=(2, 3), ids="FMI {}".format)
def version(request):
    return request.param
