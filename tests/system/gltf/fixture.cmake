# Read by ctest after Catch2 has listed the cases: they need the npm packages.
set_tests_properties(${gltf_test_TESTS} PROPERTIES FIXTURES_REQUIRED gltf_npm)
