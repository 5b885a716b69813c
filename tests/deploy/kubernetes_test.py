#!/usr/bin/env python3
"""The Kubernetes manifests, as far as they can be checked without a cluster.

References lead somewhere, selectors select, ports and volumes match, options exist; and `kubectl kustomize`,
where there is a kubectl, renders the very objects that the files hold.
"""

import shutil
import subprocess
import sys
import unittest

import yaml
from options import problems_of
from programs import ROOT

FOLDER = ROOT / "deploy" / "kubernetes"
API = {"ServiceAccount": "v1", "Service": "v1", "StatefulSet": "apps/v1", "Deployment": "apps/v1",
       "HorizontalPodAutoscaler": "autoscaling/v2", "PodDisruptionBudget": "policy/v1",
       "NetworkPolicy": "networking.k8s.io/v1"}


def load():
    """The objects of all files that kustomization.yaml names."""
    kustomization = yaml.safe_load((FOLDER / "kustomization.yaml").read_text())
    return [each for name in kustomization["resources"] for each in yaml.safe_load_all((FOLDER / name).read_text())]


def name_of(each):
    return f"{each['kind']}/{each['metadata']['name']}"


def pod_of(each):
    return each["spec"]["template"]


def selects(selector, labels):
    return bool(selector) and all(labels.get(key) == value for key, value in selector.items())


def problems(objects):
    """Everything that does not fit, one line each."""
    found = []
    names = [name_of(each) for each in objects]
    found += [f"{name}: twice" for name in set(names) if names.count(name) > 1]
    for each in objects:
        if API.get(each["kind"]) != each["apiVersion"]:
            found.append(f"{name_of(each)}: {each['kind']} is not of {each['apiVersion']}")
    workloads = [each for each in objects if each["kind"] in ("StatefulSet", "Deployment")]
    for workload in workloads:
        found += [f"{name_of(workload)}: {problem}" for problem in workload_problems(workload, names)]
    for each in objects:
        check = {"Service": service_problems, "HorizontalPodAutoscaler": autoscaler_problems,
                 "PodDisruptionBudget": budget_problems, "NetworkPolicy": policy_problems}.get(each["kind"])
        if check:
            found += [f"{name_of(each)}: {problem}" for problem in check(each, workloads)]
    return found


def workload_problems(workload, names):
    spec, pod = workload["spec"], pod_of(workload)["spec"]
    if not selects(spec["selector"]["matchLabels"], pod_of(workload)["metadata"]["labels"]):
        yield "its selector does not match its pods"
    if f"ServiceAccount/{pod['serviceAccountName']}" not in names:
        yield f"there is no service account {pod['serviceAccountName']}"
    if workload["kind"] == "StatefulSet" and f"Service/{spec['serviceName']}" not in names:
        yield f"there is no service {spec['serviceName']}"
    volumes = {volume["name"] for volume in pod.get("volumes", ())}
    volumes |= {claim["metadata"]["name"] for claim in spec.get("volumeClaimTemplates", ())}
    for container in pod["containers"]:
        mounted = {mount["name"] for mount in container.get("volumeMounts", ())}
        if mounted != volumes:
            yield f"mounts {sorted(mounted)}, has volumes {sorted(volumes)}"
        folders = {mount["mountPath"] for mount in container.get("volumeMounts", ())}
        ports = {port["containerPort"] for port in container.get("ports", ())}
        for argument in container["args"]:
            option, _, value = argument.partition("=")
            if option in ("--data", "--cache-dir") and value not in folders:
                yield f"{argument}: no volume is mounted there, and the root is read-only"
            if option in ("--listen", "--http") and int(value.rpartition(":")[2]) not in ports:
                yield f"{argument}: no such container port"
        for probe in ("startupProbe", "readinessProbe", "livenessProbe"):
            if probe in container and container[probe]["grpc"]["port"] not in ports:
                yield f"{probe}: no such container port"
        yield from problems_of(container["args"])
        security = {**pod["securityContext"], **container["securityContext"]}
        if not (security["runAsNonRoot"] and security["readOnlyRootFilesystem"]
                and not security["allowPrivilegeEscalation"] and security["capabilities"]["drop"] == ["ALL"]):
            yield "has privileges"


def named_ports(workload):
    return {port["name"]: port["containerPort"]
            for container in pod_of(workload)["spec"]["containers"] for port in container.get("ports", ())}


def selected(selector, workloads):
    return [each for each in workloads if selects(selector, pod_of(each)["metadata"]["labels"])]


def service_problems(service, workloads):
    behind = selected(service["spec"]["selector"], workloads)
    if len(behind) != 1:
        yield f"selects {len(behind)} workloads"
        return
    for port in service["spec"]["ports"]:
        if named_ports(behind[0]).get(port["targetPort"]) != port["port"]:
            yield f"port {port['name']} leads to no port of {name_of(behind[0])}"
    if "None" != service["spec"]["clusterIP"]:
        yield "is not headless"


def autoscaler_problems(scaler, workloads):
    target = scaler["spec"]["scaleTargetRef"]
    scaled = [each for each in workloads if name_of(each) == f"{target['kind']}/{target['name']}"]
    if len(scaled) != 1 or scaled[0]["apiVersion"] != target["apiVersion"]:
        yield "scales nothing"
    elif "replicas" in scaled[0]["spec"]:
        yield "fights with the number of replicas of its target"
    metrics = [metric["external"] for metric in scaler["spec"]["metrics"]]
    if [metric["metric"]["name"] for metric in metrics] != ["shutterline_desired_workers"]:
        yield "does not follow shutterline_desired_workers"
    if metrics[0]["target"] != {"type": "AverageValue", "averageValue": "1"}:
        yield "does not take the gauge for the number of replicas"
    if not 1 <= scaler["spec"]["minReplicas"] <= scaler["spec"]["maxReplicas"]:
        yield "has no sensible range"


def budget_problems(budget, workloads):
    if len(selected(budget["spec"]["selector"]["matchLabels"], workloads)) != 1:
        yield "protects no workload"


def policy_problems(policy, workloads):
    targets = selected(policy["spec"]["podSelector"]["matchLabels"], workloads)
    if len(targets) != 1:
        yield f"is for {len(targets)} workloads"
        return
    rules = [(rule, "from", targets) for rule in policy["spec"]["ingress"]]
    rules += [(rule, "to", None) for rule in policy["spec"]["egress"]]
    for rule, direction, receivers in rules:
        for peer in rule[direction]:
            labels = peer.get("podSelector", {}).get("matchLabels", {})
            others = selected(labels, workloads)
            if "app.kubernetes.io/name" in labels and len(others) != 1:
                yield f"{direction} {labels}: there is no such workload"
            for port in rule["ports"]:
                for receiver in receivers if receivers is not None else others:
                    if isinstance(port["port"], str) and port["port"] not in named_ports(receiver):
                        yield f"port {port['port']} is none of {name_of(receiver)}"


class KubernetesTest(unittest.TestCase):
    def test_everything_fits(self):
        objects = load()
        self.assertEqual(sorted(each["kind"] for each in objects), sorted(
            ["ServiceAccount", "Service", "StatefulSet", "Deployment", "HorizontalPodAutoscaler",
             "PodDisruptionBudget", "NetworkPolicy", "NetworkPolicy"]))
        self.assertEqual(problems(objects), [])

    def test_workers_dial_the_service(self):
        objects = {name_of(each): each for each in load()}
        (worker,) = pod_of(objects["Deployment/shutterline-worker"])["spec"]["containers"]
        (target,) = [word.partition("=")[2] for word in worker["args"] if word.startswith("--coordinator=")]
        service, port = target.split(":")
        self.assertIn(int(port), [each["port"] for each in objects[f"Service/{service}"]["spec"]["ports"]])
        threads = [word.partition("=")[2] for word in worker["args"] if word.startswith("--threads=")]
        self.assertEqual(threads, [worker["resources"]["limits"]["cpu"]])

    def test_mistakes_are_found(self):
        def spoil(change):
            objects = {name_of(each): each for each in load()}
            change(objects)
            return problems(list(objects.values()))

        worker, coordinator = "Deployment/shutterline-worker", "StatefulSet/shutterline-coordinator"
        container = lambda o, name: pod_of(o[name])["spec"]["containers"][0]
        for expected, change in {
                "its selector does not match": lambda o: pod_of(o[worker])["metadata"]["labels"].clear(),
                "there is no service account": lambda o: o.pop("ServiceAccount/shutterline"),
                "there is no service ": lambda o: o.pop("Service/shutterline-coordinator"),
                "mounts []": lambda o: container(o, worker).pop("volumeMounts"),
                "no such container port": lambda o: container(o, coordinator)["ports"].pop(0),
                "has no option --thread": lambda o: container(o, worker)["args"].append("--thread=3"),
                "scales nothing": lambda o: o.pop(worker),
                "fights with": lambda o: o[worker]["spec"].update(replicas=3),
                "port grpc leads to": lambda o: container(o, coordinator)["ports"][0].update(name="rpc"),
                "has privileges": lambda o: container(o, worker)["securityContext"].update(
                    allowPrivilegeEscalation=True)}.items():
            self.assertTrue(any(expected in problem for problem in spoil(change)), expected)

    def test_kubectl_renders_the_same_objects(self):
        if shutil.which("kubectl") is None:
            self.skipTest("there is no kubectl: nothing was rendered")
        done = subprocess.run(["kubectl", "kustomize", FOLDER], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        rendered = {name_of(each): each for each in yaml.safe_load_all(done.stdout)}
        written = {name_of(each): each for each in load()}
        for each in written.values():
            for container in each["spec"]["template"]["spec"]["containers"] if "template" in each.get("spec", {}) else ():
                self.assertEqual(container["image"], "shutterline")
                container["image"] = "shutterline:latest"
        self.assertEqual(rendered, written)


if __name__ == "__main__":
    sys.exit(unittest.main())
