# SPDX-License-Identifier: BSD-3-Clause
"""The robot that slam-web's page shows. Part of page_test.py."""
import os
import subprocess

from browser import wait_until
from page_drive import TOKEN


class Robot:
    """slam-sim, slamd and slam-web."""

    def __init__(self, programs, source, folder):
        self.programs, self.folder = programs, folder
        self.devices = folder / "devices"
        os.environ["SLAM_SIM_DEVICES"] = str(self.devices)
        os.environ["LD_LIBRARY_PATH"] = str(programs / "../lib/openni2")
        self.config = ["--config", str(source / "config/sim.toml")]
        (folder / "logs/run").mkdir(parents=True)
        (folder / "logs/run/0001.lcm").write_bytes(b"a log")
        self.sim = self.start("slam-sim", "--scene", "meeting-room", "--speed", "0.3", "--seconds", "600",
                              "--devices", self.devices)
        wait_until("the simulator's devices", (self.devices / "board").exists)
        self.start_slamd()
        self.start_web()

    def start(self, program, *arguments):
        with open(self.folder / f"{program}.txt", "a") as log:
            return subprocess.Popen([self.programs / program, *map(str, arguments)], stdout=log, stderr=log)

    def start_slamd(self):
        settings = {"lidar.port": self.devices / "lidar", "base.port": self.devices / "board",
                    "output.map": self.folder / "map", "store.directory": self.folder / "maps",
                    "log.directory": self.folder / "logs"}
        pairs = [f"{key}='{value}'" for key, value in settings.items()] + ["lcm.commands=true", "base.speed_commands=true"]
        self.slamd = self.start("slamd", *self.config, *(word for pair in pairs for word in ("--set", pair)))

    def start_web(self):
        self.web = self.start("slam-web", *self.config, "--set", "web.commands=true", "--set", f"web.token='{TOKEN}'",
                              "--set", "base.speed_commands=true", "--set", f"store.directory='{self.folder / 'maps'}'",
                              "--logs", self.folder / "logs")

    def start_locked_web(self):
        """A second one, which is read with the token alone."""
        return self.start("slam-web", *self.config, "--port", 8081, "--set", "web.read='token'",
                          "--set", f"web.token='{TOKEN}'")

    def inject(self, fault):
        with open(self.devices / "faults", "w") as faults:
            faults.write(fault + "\n")

    def stop(self):
        for process in (self.web, self.slamd, self.sim):
            process.kill()
            process.wait()
