#!/usr/bin/env python3
"""Holds the includes of the source tree to the modules that CMake declares.

Usage: check_layers.py ROOT MANIFEST ARROWS

MANIFEST is the modules.txt that cmake/Module.cmake writes, ARROWS says which folder may depend on which
(arrows.txt). Prints every violation as "file:line: reason" and exits with 1 if there is one. Checked:

  1. every source file under FOLDERS belongs to exactly one module, and every listed file exists;
  2. a file includes only headers of its own module and of the modules that its DEPS name;
  3. DEPS name declared modules, form no cycle, and follow the arrows;
  4. words that the arrows forbid to a folder appear in none of its includes;
  5. whatever is included by a path from the root exists; nothing but tests includes tests.

Generated headers count as well: "a/b.h" made from "a/b.h.in" belongs to the module that lists the
latter, and "….pb.h" may be included where the module or one of its direct DEPS lives under proto/.
"""

import pathlib
import re
import sys

FOLDERS = ("common", "proto", "worker", "server", "client")
SUFFIXES = (".h", ".cpp")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


class Module:
    def __init__(self, name):
        self.name, self.folder, self.deps, self.files = name, "", [], []


def read_manifest(text):
    """The modules of a manifest by name, and a list of problems."""
    modules, problems, module = {}, [], None
    for line in text.splitlines():
        key, _, rest = line.partition(" ")
        if key == "module":
            module = Module(rest)
            if rest in modules:
                problems.append(f"module {rest}: declared twice")
            modules[rest] = module
        elif key == "folder":
            module.folder = rest
        elif key == "deps":
            module.deps = rest.split()
        elif key == "files":
            module.files = rest.split()
        elif line.strip():
            problems.append(f"manifest: unknown line '{line}'")
    return modules, problems


def read_arrows(text):
    """({folder: allowed folders}, {folder: forbidden words})."""
    arrows, forbidden = {}, {}
    for line in text.splitlines():
        line = line.partition("#")[0].strip()
        if not line:
            continue
        left, colon, right = line.partition(":")
        if not colon:
            raise ValueError(f"arrows: no ':' in '{line}'")
        if left.startswith("forbid "):
            forbidden[left.split()[1]] = right.split()
        else:
            arrows[left.strip()] = right.split()
    return arrows, forbidden


def is_under(path, folder):
    return path == folder or path.startswith(folder + "/")


def layer_of(module, arrows):
    """The module itself or the longest folder that holds it, whichever the arrows name, or None."""
    if module.name in arrows:
        return module.name
    return max((layer for layer in arrows if is_under(module.folder, layer)), key=len, default=None)


def may_depend(layer, target, arrows):
    """Whether the arrows let `layer` use the module `target`; an arrow to a folder covers all that is in it."""
    return any(target.name == allowed or is_under(target.folder, allowed) for allowed in [layer] + arrows[layer])


def check_declarations(modules, arrows):
    problems = []
    for module in modules.values():
        layer = layer_of(module, arrows)
        if layer is None:
            if not is_under(module.folder, "tests"):
                problems.append(f"module {module.name}: no arrow speaks of its folder {module.folder}")
            continue
        for dep in module.deps:
            if dep not in modules:
                problems.append(f"module {module.name}: DEPS name {dep}, which is no module "
                                "(libraries of others go into LIBS)")
                continue
            if not may_depend(layer, modules[dep], arrows):
                problems.append(f"module {module.name}: {layer} must not depend on "
                                f"{modules[dep].folder} (module {dep})")
    return problems + find_cycles(modules)


def find_cycles(modules):
    """One line for each cycle that a depth-first walk of the DEPS closes."""
    problems, finished, path = [], set(), []

    def walk(name):
        if name in path:
            problems.append("cycle of DEPS: " + " -> ".join(path[path.index(name):] + [name]))
            return
        if name in finished or name not in modules:
            return
        path.append(name)
        for dep in modules[name].deps:
            walk(dep)
        path.pop()
        finished.add(name)

    for name in sorted(modules):
        walk(name)
    return problems


def includes_of(path):
    """(line number, '<' or '"', what) of every include directive."""
    text = path.read_text(encoding="utf-8", errors="replace")
    for number, line in enumerate(text.splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match[1], match[2]


def own_files(modules, problems):
    owner = {}
    for module in modules.values():
        for file in module.files:
            if file in owner and owner[file] is not module:
                problems.append(f"{file}: belongs to both {owner[file].name} and {module.name}")
            owner[file] = module
    return owner


def check_include(root, file, module, included, owner, modules):
    """The reason why `module` must not include "`included`", or None."""
    if is_under(included, "tests"):
        return f'"{included}": only tests may include tests'
    reach = [module] + [modules[dep] for dep in module.deps if dep in modules]
    if included.endswith(".pb.h"):
        if any(is_under(other.folder, "proto") for other in reach):
            return None
        return f'"{included}": generated code, and no module of proto is in the DEPS of {module.name}'
    target = owner.get(included) or owner.get(included + ".in")
    if target is None:
        if (root / included).exists():
            return f'"{included}": no module lists this file'
        return f'"{included}": no such file (includes are written from the root)'
    if target not in reach:
        return f'"{included}": {target.name} is not in the DEPS of {module.name}'
    return None


def check_tree(root, manifest_text, arrows_text):
    """Every violation in the tree at `root`, one line each."""
    modules, problems = read_manifest(manifest_text)
    arrows, forbidden = read_arrows(arrows_text)
    problems += check_declarations(modules, arrows)
    owner = own_files(modules, problems)
    problems += [f"{file}: listed by {module.name}, but missing"
                 for file, module in owner.items() if not (root / file).exists()]

    sources = [path for folder in FOLDERS for path in sorted((root / folder).rglob("*"))
               if path.suffix in SUFFIXES]
    for path in sources:
        file = path.relative_to(root).as_posix()
        module = owner.get(file)
        if module is None:
            problems.append(f"{file}: no module lists this file")
        for number, bracket, included in includes_of(path):
            for folder, words in forbidden.items():
                if is_under(file, folder) and any(word in included for word in words):
                    problems.append(f"{file}:{number}: {included} must not be included below {folder}")
            if bracket == '"' and module is not None:
                reason = check_include(root, file, module, included, owner, modules)
                if reason:
                    problems.append(f"{file}:{number}: {reason}")
    if not sources:
        problems.append(f"{root}: no sources found")
    return problems


def main(arguments):
    if len(arguments) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    root, manifest, arrows = map(pathlib.Path, arguments)
    problems = check_tree(root, manifest.read_text(encoding="utf-8"), arrows.read_text(encoding="utf-8"))
    for problem in problems:
        print(problem)
    print(f"layers: {len(problems)} violations" if problems else "layers: every include follows the declarations")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
