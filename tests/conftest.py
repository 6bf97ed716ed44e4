"""Options of the tests as a whole."""


def pytest_addoption(parser):
    parser.addoption("--rays", type=int, default=20_000, metavar="N",
                     help="rays for each mesh and accelerator in tests/python/test_accelerators.py")
