"""Prints a line for each test function of a Python file, with the word "slow" if it is marked so. For CMake."""

import ast
import sys
from pathlib import Path


def is_slow(function):
    return any(ast.unparse(mark) == "pytest.mark.slow" for mark in function.decorator_list)


for statement in ast.parse(Path(sys.argv[1]).read_text()).body:
    if isinstance(statement, ast.FunctionDef) and statement.name.startswith("test_"):
        print(statement.name, *(["slow"] if is_slow(statement) else []))
