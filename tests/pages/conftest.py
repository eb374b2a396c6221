def pytest_addoption(parser):
    parser.addoption("--long", action="store_true", help="also the fences that take minutes")
    parser.addoption("--write", action="store_true", help="write what was printed into the pages")
