"""Functions generated of a chain's table: the same as the product of the matrices, and fast."""

import ast

import pytest
from chain_cases import MINI_MOVER, PUMA, chains, chains_and_values, gap
from hypothesis import given

from kinematics.chains.chain import Chain
from kinematics.chains.generated import generated
from kinematics.chains.links import DHLink
from kinematics.errors import KinematicsError


@given(chains_and_values())
def test_the_generated_transform_is_the_product_of_the_matrices(case):
    chain, values = case
    assert gap(generated(chain).fk(values), chain.fk(values)) < 1e-9


@given(chains_and_values(most=6))
def test_both_at_once_are_the_same_as_each(case):
    chain, values = case
    made = generated(chain)
    assert made.fk_and_jacobian(values) == (made.fk(values), made.jacobian(values))


@given(chains())
def test_the_source_is_straight_line_arithmetic(chain):
    allowed = (
        ast.Module, ast.FunctionDef, ast.arguments, ast.arg, ast.Assign, ast.Return, ast.Tuple,
        ast.Name, ast.Constant, ast.BinOp, ast.UnaryOp, ast.Call, ast.Load, ast.Store, ast.Add,
        ast.Sub, ast.Mult, ast.USub,
    )  # fmt: skip
    tree = ast.parse(generated(chain).source)
    assert all(isinstance(node, allowed) for node in ast.walk(tree))
    called = {node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call)}
    assert called <= {"sin", "cos"}


def operations(chain):
    """Multiplications, additions, and calls of sine and cosine in the generated transform."""
    function = ast.parse(generated(chain).source).body[0]
    nodes = list(ast.walk(function))
    binary = [node.op for node in nodes if isinstance(node, ast.BinOp)]
    calls = sum(isinstance(node, ast.Call) for node in nodes)
    products = sum(isinstance(op, ast.Mult) for op in binary)
    return products, len(binary) - products, calls


def test_parallel_joints_are_one_sum_of_angles():
    assert operations(MINI_MOVER)[2] == 10  # two a joint: none is called for twice
    assert "cos(v4)" in generated(MINI_MOVER).source
    assert operations(MINI_MOVER)[0] < 30  # products of 4x4 matrices take 286
    assert operations(PUMA)[0] < 60


def test_a_chain_is_generated_once():
    assert generated(PUMA) is generated(Chain(PUMA.links, name="Puma 560"))


class Symbol(float):
    """A number that brings its own functions."""

    def sin(self):
        return self

    cos = sin


def test_only_plain_numbers_are_generated():
    with pytest.raises(KinematicsError, match=r"plain numbers; use Chain\.fk"):
        generated(Chain((DHLink(a_mm=Symbol(3.0)),)))
