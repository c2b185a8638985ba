"""Drives the operator's page in headless Chromium.

    python -m venv V && V/bin/pip install selenium
    V/bin/python page_test.py [--base-url http://127.0.0.1:PORT/] [--token T] [--shots FOLDER]
                              [--axe axe.min.js] [--try-fault SECONDS] [--patience FACTOR]
                              [--only TEXT]

Without --base-url it starts the mock and checks everything; with it the checks that need the mock
are skipped. --axe takes the script of the npm package axe-core and checks contrast, names and roles.
"""

import argparse
import shutil
import sys
import time
import traceback
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.append(str(Path(__file__).resolve().parents[4] / "tests" / "browser"))

import anywhere
import modules
import scripted
from browser import Browser
from mock import Mock

#: What the browser itself logs of calls that were made to fail.
EXPECTED = ("Failed to load resource", "net::ERR_")


def options():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--base-url", help="address of a running service, ending in /")
    parser.add_argument("--token", help="token of that service")
    parser.add_argument("--shots", type=Path, help="folder for pictures of the page")
    parser.add_argument("--axe", type=Path, help="axe.min.js of the npm package axe-core")
    parser.add_argument(
        "--try-fault", type=float, metavar="SECONDS",
        help="start a fault of the embedded turbine and wait so long for its alarm",
    )
    parser.add_argument("--patience", type=float, default=1.0, help="factor on all waits, for a busy machine")
    parser.add_argument("--only", default="", help="only checks whose name holds this")
    parser.add_argument("--chromium", default=shutil.which("chromium"))
    parser.add_argument("--chromedriver", default=shutil.which("chromedriver"))
    return parser.parse_args()


def main():
    given = options()
    if given.shots:
        given.shots.mkdir(parents=True, exist_ok=True)
    mock = None if given.base_url else Mock()
    url = given.base_url or mock.url
    context = {"url": url, "token": given.token, "axe": given.axe, "shots": given.shots, "try_fault": given.try_fault}
    browser = Browser(given.chromium, given.chromedriver, given.patience)
    count = {"passed": 0, "failed": 0, "skipped": 0}

    def run(check, quiet_but, **arguments):
        name = check.__name__
        if given.only not in name:
            return
        began = time.monotonic()
        try:
            told = check(browser, **arguments)
            browser.assert_quiet(quiet_but)
        except Exception:
            traceback.print_exc()
            count["failed"] += 1
            print(f"FAILED  {name}", flush=True)
            browser.collect()
            browser.console.clear()
            browser.look(1400, "light")
            return
        if told is anywhere.SKIPPED:
            count["skipped"] += 1
            print(f"skipped {name}: its option is not given", flush=True)
            return
        count["passed"] += 1
        print(f"ok      {name} ({time.monotonic() - began:.1f} s){f': {told}' if told else ''}", flush=True)

    try:
        if given.only and mock is None:
            anywhere.load(browser, url, given.token)
        elif given.only:
            anywhere.load(browser, url)
        for check in anywhere.CHECKS + modules.CHECKS:
            run(check, ("401 (Unauthorized)",) if given.token else (), **context)
        for checks, quiet_but in ((scripted.CHECKS, ()), (scripted.LOUD, EXPECTED)):
            for check in checks:
                if mock is None:
                    count["skipped"] += 1
                    print(f"skipped {check.__name__}: it needs the mock")
                    continue
                shots = {"shots": given.shots} if check is scripted.lost_connection_is_shown else {}
                run(check, quiet_but, mock=mock, **shots)
        for check in anywhere.LAST:
            run(check, EXPECTED, **context)
    finally:
        browser.close()
    print(f"{count['passed']} passed, {count['failed']} failed, {count['skipped']} skipped")
    return 1 if count["failed"] else 0


if __name__ == "__main__":
    sys.exit(main())
