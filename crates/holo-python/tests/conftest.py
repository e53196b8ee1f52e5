"""What the tests share: one small render."""

import holo
import pytest

OPTIONS = dict(views=(5, 4), lenses=(48, 72), spp=2, seed=7, disparity=(-1.0, 1.0))


@pytest.fixture(scope="session")
def garden():
    return holo.Scene.gallery("garden")


@pytest.fixture(scope="session")
def rendering(garden):
    return holo.render(garden, layers=["depth", "disparity", "shading-normal"], **OPTIONS)


@pytest.fixture(scope="session")
def options():
    return OPTIONS
