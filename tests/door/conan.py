"""Plays Conan: does with the recipe what `conan create` does, with what the system has in place of other packages, and
builds a host by what package_info() says. conan.py SOURCE FOLDER VERSION COMPILER full|brief"""

import importlib.util
import os
import shutil
import subprocess
import sys
import types
from collections import defaultdict

source, folder, version, compiler, rounds = sys.argv[1:]


def run(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        sys.exit(" ".join(command) + "\n" + done.stdout[-4000:])


class Properties:
    def __init__(self, *_):
        self.properties, self.cache_variables = {}, {}

    def set_property(self, *words):
        self.properties[words[:-1]] = words[-1]

    def generate(self):
        self.generated = True


class Toolchain(Properties):
    def generate(self):
        used.update(self.cache_variables)


class CMake:
    def __init__(self, recipe):
        self.recipe, self.build_folder = recipe, folder + "/build"

    def configure(self):
        text = lambda value: value if isinstance(value, str) else "ON" if value else "OFF"
        run("cmake", "-S", self.recipe.source_folder, "-B", self.build_folder, "-G", "Ninja", "-DCMAKE_CXX_COMPILER=" + compiler,
            "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_INSTALL_LIBDIR=lib", "-DCMAKE_PROJECT_fjell_INCLUDE=" + source + "/tests/door/in_a_hurry.cmake",
            "-DCMAKE_INSTALL_PREFIX=" + self.recipe.package_folder, *(f"-D{k}={text(v)}" for k, v in used.items()))

    def build(self):
        run("cmake", "--build", self.build_folder, "-j", "2")

    def install(self):
        run("cmake", "--install", self.build_folder)


def copy(_, pattern, start, end):
    path = os.path.join(start, pattern.removesuffix("/*"))
    if os.path.isdir(path):
        shutil.copytree(path, os.path.join(end, os.path.basename(path)))
    else:
        os.makedirs(end, exist_ok=True)
        shutil.copy(path, end)


def module(name, **contents):
    sys.modules[name] = types.ModuleType(name)
    vars(sys.modules[name]).update(contents)


used = {}
module("conan", ConanFile=object)
module("conan.tools")
module("conan.tools.build", check_min_cppstd=lambda *_: None)
module("conan.tools.cmake", CMake=CMake, CMakeDeps=Properties, CMakeToolchain=Toolchain, cmake_layout=lambda *_: None)
module("conan.tools.files", copy=copy, load=lambda _, path: open(path).read(), rmdir=lambda _, path: shutil.rmtree(path))

path = source + "/runtime/install/conan/conanfile.py"
spec = importlib.util.spec_from_file_location("conanfile", path)
conanfile = importlib.util.module_from_spec(spec)
spec.loader.exec_module(conanfile)
recipe = conanfile.Fjell()
recipe.recipe_folder = os.path.dirname(path)
recipe.options = types.SimpleNamespace(**dict(recipe.default_options, profile=True))
recipe.settings = types.SimpleNamespace(os="Linux")
recipe.dependencies = defaultdict(lambda: types.SimpleNamespace(cpp_info=types.SimpleNamespace(includedirs=[folder + "/xxhash"])))
recipe.cpp_info = types.SimpleNamespace(components=defaultdict(lambda: Properties()))
required = []
recipe.requires = lambda package, **_: required.append(package.split("/")[0])
recipe.tool_requires = lambda package: None
shutil.rmtree(folder, ignore_errors=True)
recipe.export_sources_folder = recipe.source_folder = folder + "/source"
recipe.package_folder = folder + "/package"

recipe.set_version()
if recipe.version != version:
    sys.exit(f"the recipe is of version {recipe.version}, and this is {version}")
recipe.requirements()
recipe.build_requirements()
recipe.validate()
recipe.package_info()
for name, component in recipe.cpp_info.components.items():
    for need in component.requires:
        if need.split("::")[0] not in required and need not in recipe.cpp_info.components:
            sys.exit(f"fjell::{name} needs {need}, which the recipe does not require")
if rounds != "full":
    sys.exit(print("skipped: building what the recipe exports (FJELL_TEST_ROUNDS=full does it)"))

shutil.copytree("/usr/include", folder + "/xxhash", ignore=lambda _, names: [n for n in names if n not in ("xxhash.h", "xxh3.h")])
recipe.export_sources()
recipe.layout()
recipe.generate()
recipe.build()
recipe.package()
with open(folder + "/main.cpp", "w") as file:
    file.write("#include <fjell/profile.h>\nint main() { return fjell::live_options(fjell::parse_profile(\"\", \"none\")).page_slots == 0; }\n")
others = {"highway": ["-lhwy"], "zstd": ["-lzstd"], "fmt": ["-lfmt"], "tomlplusplus": ["-ltomlplusplus"], "xxhash": []}
libraries = []
for component in reversed(recipe.cpp_info.components.values()):
    libraries += ["-l" + library for library in component.libs]
    libraries += ["-l" + library for library in getattr(component, "system_libs", [])]
for package in required:
    libraries += others[package]
package = recipe.package_folder
if not os.path.exists(package + "/licenses/LICENSE") or os.path.exists(package + "/lib/cmake"):
    sys.exit("the package lacks its licence, or has a configuration for CMake of its own")
run(compiler, "-std=c++20", folder + "/main.cpp", "-o", folder + "/main", "-I" + package + "/include", "-L" + package + "/lib", *libraries)
run(folder + "/main")
