# SPDX-License-Identifier: BSD-3-Clause
"""What each test of slam-web's page begins with: programs, a robot, and chromedriver."""
import contextlib
import pathlib
import shutil
import subprocess
import sys
import tempfile

from page_robot import Robot

SKIPPED = 77
UNLOCK = "document.getElementById('token').value = '%s'; document.querySelector('#login button').click()"


@contextlib.contextmanager
def session(begin=Robot):
    """Usage of such a test: TEST BIN SOURCE OUT. @param begin makes of BIN, SOURCE and a folder what has stop()
    @return (chromium, robot, source, out); the logs are copied to OUT"""
    programs, source, out = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not chromium or not driver:
        print("skipped: install chromium and chromium-driver")
        sys.exit(SKIPPED)
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        with open(folder / "driver.txt", "w") as log:
            webdriver = subprocess.Popen([driver, "--port=9515"], stdout=log, stderr=log)
        robot = begin(programs, source, folder)
        try:
            yield chromium, robot, source, out
        finally:
            robot.stop()
            webdriver.terminate()
            webdriver.wait()
            for log in folder.glob("*.txt"):
                shutil.copy(log, out / log.name)
