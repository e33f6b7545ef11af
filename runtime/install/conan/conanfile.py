"""A recipe for Conan 2, of the checkout that it lies in: conan create runtime/install/conan --build=missing"""

import os
import re

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load, rmdir

CHECKOUT = ("CMakeLists.txt", "LICENSE", "runtime/*", "profiles/*")


class Fjell(ConanFile):
    name = "fjell"
    description = "Terrain for game loops: crack-free, error-bounded, inside fixed budgets"
    license = "MIT"
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False], "profile": [True, False]}
    default_options = {"shared": False, "profile": False}

    def _checkout(self):
        return os.path.join(self.recipe_folder, "..", "..", "..")

    def set_version(self):
        text = load(self, os.path.join(self._checkout(), "CMakeLists.txt"))
        self.version = re.search(r"project\(fjell\s+VERSION ([0-9.]+)", text).group(1)

    def export_sources(self):
        for pattern in CHECKOUT:
            copy(self, pattern, self._checkout(), self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def requirements(self):
        self.requires("highway/[>=1.0]")
        self.requires("xxhash/[>=0.8]")
        self.requires("zstd/[>=1.5 <1.6]")
        if self.options.profile:
            self.requires("fmt/[>=9]")
            self.requires("tomlplusplus/[>=3]")

    def build_requirements(self):
        self.tool_requires("pkgconf/[>=2]")

    def validate(self):
        check_min_cppstd(self, 20)

    def generate(self):
        dependencies = CMakeDeps(self)
        dependencies.set_property("highway", "cmake_file_name", "hwy")  # as Highway's own installation is found
        dependencies.set_property("highway::hwy", "cmake_target_name", "hwy::hwy")
        dependencies.generate()
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["FJELL_TOOLS"] = False
        toolchain.cache_variables["FJELL_INSTALL"] = True
        toolchain.cache_variables["FJELL_PROFILE"] = bool(self.options.profile)
        headers = self.dependencies["xxhash"].cpp_info.includedirs  # it has no target that Fjell asks for
        toolchain.cache_variables["CMAKE_CXX_STANDARD_INCLUDE_DIRECTORIES"] = ";".join(headers)
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        for folder in "cmake", "pkgconfig":  # consumers get Conan's own
            rmdir(self, os.path.join(self.package_folder, "lib", folder))

    def package_info(self):
        libraries = {"runtime": ["highway::hwy", "xxhash::xxhash", "zstd::zstdlib"], "io": ["runtime"]}
        if self.options.profile:
            libraries["profile"] = ["io", "fmt::fmt", "tomlplusplus::tomlplusplus"]
        for library, needs in libraries.items():
            component = self.cpp_info.components[library]
            component.libs = ["fjell_" + library]
            component.requires = needs
            component.set_property("cmake_target_name", "fjell::" + library)
        if self.settings.os == "Linux":
            self.cpp_info.components["io"].system_libs = ["pthread"]
