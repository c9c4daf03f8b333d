"""Symbols against an independent computer algebra: the folded products are the same functions."""

import math

import pytest

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink
from kinematics.frames.transforms import compose
from kinematics.textbook.symbols import as_symbol
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.worked_example import joint_symbols, symbolic_chain, symbolic_system

sympy = pytest.importorskip("sympy", reason="the computer algebra to compare with is missing")

QUARTER = math.pi / 2


class Foreign:
    """A sympy expression that brings its own functions, as `kinematics.frames.numbers` asks."""

    def __init__(self, expression):
        self.expression = sympy.nsimplify(expression)

    def __add__(self, other):
        return Foreign(self.expression + _expression(other))

    def __sub__(self, other):
        return Foreign(self.expression - _expression(other))

    def __rsub__(self, other):
        return Foreign(_expression(other) - self.expression)

    def __mul__(self, other):
        return Foreign(self.expression * _expression(other))

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self):
        return Foreign(-self.expression)

    def sin(self):
        return Foreign(sympy.sin(self.expression))

    def cos(self):
        return Foreign(sympy.cos(self.expression))


def _expression(value):
    return value.expression if isinstance(value, Foreign) else sympy.nsimplify(value)


def foreign(symbols):
    return {
        name: Foreign(sympy.Symbol(name))
        for symbol in symbols
        for name in as_symbol(symbol).names()
    }


def assert_same(symbolic, theirs):
    names = foreign(entry for row in symbolic for entry in row)
    for row, other in zip(symbolic, theirs, strict=True):
        for entry, expected in zip(row, other, strict=True):
            ours = _expression(as_symbol(entry).value(names))
            assert sympy.expand_trig(ours - _expression(expected)).expand() == 0


@pytest.mark.parametrize("convention", Convention)
def test_the_product_of_a_chain_is_the_one_of_the_computer_algebra(convention):
    links = (
        DHLink(d_mm=1.0, alpha_rad=QUARTER),
        DHLink(a_mm=1.0),
        DHLink(a_mm=1.0, offset=QUARTER, alpha_rad=-QUARTER),
    )
    chain = symbolic_chain(Chain(links, convention))
    joints = joint_symbols(chain)
    theirs = compose(
        *(
            DHLink(
                d_mm=_foreign_or_zero(link.d_mm),
                a_mm=_foreign_or_zero(link.a_mm),
                alpha_rad=link.alpha_rad,
            ).matrix(Foreign(sympy.Symbol(f"theta{number}") + _turn(link)), convention)
            for number, link in enumerate(chain.links, 1)
        )
    )
    assert_same(chain.fk(joints), theirs)


def _turn(link):
    return sympy.pi / 2 if link.offset else 0


def _foreign_or_zero(length):
    names = as_symbol(length).names()
    return Foreign(sympy.Symbol(next(iter(names)))) if names else 0.0


@pytest.mark.parametrize("name", ["two-link-1", "two-link-2", "three-link", "spherical"])
def test_a_systems_closed_form_is_its_product_in_the_computer_algebra(name):
    system = symbolic_system(SYSTEMS[name])
    chain = system.chain()
    joints = joint_symbols(chain)
    closed = system.fk(joints)
    names = foreign(entry for row in closed for entry in row)
    # the product of matrices whose entries the computer algebra multiplies
    matrices = (chain.base, *chain.matrices(joints), chain.tool)
    product = compose(
        *(
            tuple(
                tuple(Foreign(_expression(as_symbol(e).value(names))) for e in row) for row in one
            )
            for one in matrices
        )
    )
    assert_same(closed, product)
