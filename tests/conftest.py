"""Options of the tests as a whole."""

import signal


def pytest_configure():
    # A shell starts what goes on in the background with Ctrl-C ignored, and the processes of tests would inherit that.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser):
    parser.addoption("--rays", type=int, default=20_000, metavar="N",
                     help="rays for each mesh and accelerator in tests/python/test_accelerators.py")
