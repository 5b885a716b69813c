#!/usr/bin/env python3
"""The Open Job Description template: its structure, as far as it uses the specification, and its script."""

import re
import subprocess
import sys
import unittest

import yaml
from programs import ROOT, Farm, Programs, program, wait_until

TEMPLATE = ROOT / "deploy" / "openjd" / "workers.yaml"
REFERENCE = re.compile(r"{{\s*([\w.]+)\s*}}")


def strings(value):
    """Every string below a value."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, (dict, list)):
        for each in value.values() if isinstance(value, dict) else value:
            yield from strings(each)


class OpenJobDescriptionTest(unittest.TestCase):
    def setUp(self):
        self.template = yaml.safe_load(TEMPLATE.read_text())
        (self.step,) = self.template["steps"]
        self.parameters = {each["name"]: each for each in self.template["parameterDefinitions"]}

    def test_structure(self):
        self.assertEqual(set(self.template), {"specificationVersion", "name", "parameterDefinitions", "steps"})
        self.assertEqual(self.template["specificationVersion"], "jobtemplate-2023-09")
        allowed = {"INT": {"minValue", "maxValue"}, "STRING": {"minLength", "maxLength"}}
        for name, parameter in self.parameters.items():
            self.assertRegex(name, r"^[A-Za-z_]\w{0,63}$")
            self.assertLessEqual(set(parameter) - {"name", "type", "description", "default"},
                                 allowed[parameter["type"]], name)
            if parameter["type"] == "INT":
                self.assertIsInstance(parameter["default"], int)
                self.assertTrue(parameter["minValue"] <= parameter["default"] <= parameter["maxValue"], name)
        self.assertEqual(set(self.step), {"name", "hostRequirements", "parameterSpace", "script"})
        (task,) = self.step["parameterSpace"]["taskParameterDefinitions"]
        self.assertEqual((task["name"], task["type"]), ("Worker", "INT"))
        self.assertRegex(REFERENCE.sub("7", task["range"]), r"^\d+-\d+$")
        for amount in self.step["hostRequirements"]["amounts"]:
            self.assertRegex(amount["name"], r"^amount\.worker\.(vcpu|memory)$")
        run = self.step["script"]["actions"]["onRun"]
        self.assertEqual(set(run), {"command", "args", "cancelation"})
        self.assertEqual(run["cancelation"]["mode"], "NOTIFY_THEN_TERMINATE")
        self.assertTrue(1 <= run["cancelation"]["notifyPeriodInSeconds"] <= 600)

    def test_references_lead_somewhere(self):
        known = {f"Param.{name}" for name in self.parameters} | {"Task.Param.Worker", "Session.WorkingDirectory"}
        known |= {f"Task.File.{file['name']}" for file in self.step["script"]["embeddedFiles"]}
        used = {name for text in strings(self.template) for name in REFERENCE.findall(text)}
        self.assertEqual(used - known, set())
        self.assertEqual({f"Param.{name}" for name in self.parameters} - used, set(), "parameters that nobody reads")

    def test_a_task_runs_a_worker_that_leaves_when_notified(self):
        with Programs("openjd") as programs:
            farm = Farm(programs)
            values = {"Param.Coordinator": farm.address, "Param.Threads": "1", "Param.MoreArguments": "--log-level debug",
                      "Param.Workers": "1", "Task.Param.Worker": "1", "Session.WorkingDirectory": str(programs.folder)}
            (file,) = self.step["script"]["embeddedFiles"]
            script = programs.folder / "run"
            script.write_text(REFERENCE.sub(lambda match: values[match[1]], file["data"]))
            folder = program("shutterline-worker").rpartition("/")[0]
            task = programs.start("task", ["bash", script], env={"PATH": f"{folder}:/usr/bin:/bin"})
            farm.wait_for_workers(1)
            self.assertTrue(farm.workers()[0]["name"].endswith(":1"))
            task.terminate()
            self.assertEqual(task.wait(20), 0, programs.log("task").read_text())
            self.assertIn("draining", programs.log("task").read_text())
            farm.wait_for_workers(0)


if __name__ == "__main__":
    sys.exit(unittest.main())
