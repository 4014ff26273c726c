#include "tests/check.hpp"
TEST("x") { CHECK(true); }
