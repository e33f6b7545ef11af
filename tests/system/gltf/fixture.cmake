# Read by ctest after Catch2 has listed the cases: they need the npm packages.
set_tests_properties(${system_gltf_TESTS} PROPERTIES FIXTURES_REQUIRED gltf_npm)
