"""Boxes and triangles against rays, as vector instructions that numba does not find by itself.

Eight boxes or eight triangles against one ray, or one box against a group of sixteen rays. Nodes and triangles lie in
float32; rays of float64 lanes are compared in float64. An arrangement of eight numbers side by side is a *row* here: a
node has a row for each side of its boxes, a leaf a row for each coordinate of its corners. A row of a group of rays has
sixteen numbers.
"""

import math

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

WIDTH = 8               # boxes of a node, triangles of a leaf
# Rows of a node: least x, greatest x, least y, … of its boxes, then their links. Rows of a leaf: x, y, z of the first,
# second and third corners, then the numbers of the triangles
NODE_ROWS, LINKS = 8, 6
LEAF_ROWS, NUMBERS = 10, 9
SLACK = 1e-6            # of the sum of a triangle's weights: rays through a corner, where several edges round apart
WIDER = 1.0 + 4e-7      # of the far side of a box: more than rounding may take from it
GROUP = 16              # rays of a group
# Rows of a group: origins, directions, inverse components of these, greatest distances; then the weights of the second
# and third corners of the triangles found
ORIGIN, DIRECTION, INVERSE, MOST, SECOND, THIRD, GROUP_ROWS = 0, 3, 6, 9, 10, 11, 12


class _Vectors:
    """Arithmetic of vectors of `count` numbers in the type of a ray; tables in memory are float32."""

    def __init__(self, context, builder, kind, count=WIDTH):
        self.context, self.builder, self.count = context, builder, count
        self.scalar = context.get_value_type(kind)
        self.vector = ir.VectorType(self.scalar, count)
        self.stored = ir.VectorType(ir.FloatType(), count)

    def spread(self, scalar) -> ir.Value:
        one = self.builder.insert_element(ir.Constant(self.vector, ir.Undefined), scalar,
                                          ir.Constant(ir.IntType(32), 0))
        everywhere = ir.Constant(ir.VectorType(ir.IntType(32), self.count), [0] * self.count)
        return self.builder.shuffle_vector(one, one, everywhere)

    def load(self, data, index) -> ir.Value:
        there = self.builder.bitcast(self.builder.gep(data, [index]), self.stored.as_pointer())
        loaded = self.builder.load(there, align=4)
        return loaded if self.vector == self.stored else self.builder.fpext(loaded, self.vector)

    def spread_from(self, data, index) -> ir.Value:
        """One number of a table, in all places of a vector."""
        loaded = self.builder.load(self.builder.gep(data, [index]))
        return self.spread(loaded if self.scalar == ir.FloatType() else self.builder.fpext(loaded, self.scalar))

    def load_row(self, data, number) -> ir.Value:
        """A row of rays in their own type."""
        there = self.builder.gep(data, [ir.Constant(ir.IntType(64), number * self.count)])
        return self.builder.load(self.builder.bitcast(there, self.vector.as_pointer()), align=4)

    def store(self, value, data, index) -> None:
        there = self.builder.bitcast(self.builder.gep(data, [index]), self.vector.as_pointer())
        self.builder.store(value, there, align=4)

    def add(self, a, b) -> ir.Value:
        return self.builder.fadd(a, b, flags=("contract",))

    def sub(self, a, b) -> ir.Value:
        return self.builder.fsub(a, b, flags=("contract",))

    def mul(self, a, b) -> ir.Value:
        return self.builder.fmul(a, b, flags=("contract",))

    def larger(self, a, b) -> ir.Value:
        return self.builder.select(self.builder.fcmp_ordered(">", a, b), a, b)

    def smaller(self, a, b) -> ir.Value:
        return self.builder.select(self.builder.fcmp_ordered("<", a, b), a, b)

    def constant(self, number) -> ir.Value:
        return ir.Constant(self.vector, [number] * self.count)

    def dot(self, a, b) -> ir.Value:
        x, y, z = (self.mul(p, q) for p, q in zip(a, b, strict=True))
        return self.add(self.add(x, y), z)

    def cross(self, a, b) -> list[ir.Value]:
        return [self.sub(self.mul(a[i], b[j]), self.mul(a[j], b[i])) for i, j in ((1, 2), (2, 0), (0, 1))]

    def mask(self, flags) -> ir.Value:
        """Bits of the flags, int32."""
        return self.builder.zext(self.builder.bitcast(flags, ir.IntType(self.count)), ir.IntType(32))

    def least(self, a) -> ir.Value:
        """The least of the numbers of a vector, none of which is NaN."""
        name = f"llvm.vector.reduce.fmin.v{self.count}{'f32' if self.scalar == ir.FloatType() else 'f64'}"
        reduce = cgutils.get_or_insert_function(self.builder.module, ir.FunctionType(self.scalar, [self.vector]), name)
        return self.builder.call(reduce, [a], fastmath=("nnan",))


def _data(context, builder, kind, value) -> ir.Value:
    return context.make_array(kind)(context, builder, value).data


@intrinsic
def boxes_met(typing, nodes, first, near, origin, inverse, most, distances):
    """Bits of the boxes of a node that a ray enters before `most`; distances[0 … 7]: where it enters them, at least 0.

    nodes: float32; first: of the numbers of the node; near: offsets of the sides that the ray meets first, 0 or WIDTH
    each; origin, inverse: of the ray, inverse components of its direction; three numbers each.
    """
    real = most

    def build(context, builder, signature, arguments):
        table, node, near_, origin_, inverse_, most_, distances_ = arguments
        data = _data(context, builder, signature.args[0], table)
        out = _data(context, builder, signature.args[6], distances_)
        of = _Vectors(context, builder, real)
        begin, end = of.constant(0.0), of.spread(most_)
        for axis in range(3):
            start, per = (of.spread(builder.extract_value(three, axis)) for three in (origin_, inverse_))
            offset = builder.extract_value(near_, axis)
            word = offset.type
            row = builder.add(node, ir.Constant(word, 2 * WIDTH * axis))
            close = of.load(data, builder.add(row, offset))
            far = of.load(data, builder.add(row, builder.sub(ir.Constant(word, WIDTH), offset)))
            begin = of.larger(of.mul(of.sub(close, start), per), begin)
            end = of.smaller(of.mul(of.sub(far, start), per), end)
        of.store(begin, out, ir.Constant(ir.IntType(64), 0))
        return of.mask(builder.fcmp_ordered("<=", begin, of.mul(end, of.constant(WIDER))))

    three = types.UniTuple(real, 3)
    return types.int32(nodes, types.intp, types.UniTuple(types.intp, 3), three, three, real, distances), build


@intrinsic
def box_met(typing, nodes, box, near, group):
    """Bits of the rays of a group that enter one box before their MOST; the least distance at which one enters it.

    nodes: float32; box: of the least x of the box; near: offsets of the sides that all rays meet first, 0 or WIDTH
    each; group: rows of the rays, of which ORIGIN, INVERSE and MOST are read. Distances are rounded as in `boxes_met`.
    """
    real = group.dtype

    def build(context, builder, signature, arguments):
        table, place_, near_, group_ = arguments
        data = _data(context, builder, signature.args[0], table)
        rays = _data(context, builder, signature.args[3], group_)
        of = _Vectors(context, builder, real, GROUP)
        begin, end = of.constant(0.0), of.load_row(rays, MOST)
        for axis in range(3):
            start, per = of.load_row(rays, ORIGIN + axis), of.load_row(rays, INVERSE + axis)
            offset = builder.extract_value(near_, axis)
            word = offset.type
            row = builder.add(place_, ir.Constant(word, 2 * WIDTH * axis))
            close = of.spread_from(data, builder.add(row, offset))
            far = of.spread_from(data, builder.add(row, builder.sub(ir.Constant(word, WIDTH), offset)))
            begin = of.larger(of.mul(of.sub(close, start), per), begin)
            end = of.smaller(of.mul(of.sub(far, start), per), end)
        entered = builder.fcmp_ordered("<=", begin, of.mul(end, of.constant(WIDER)))
        first = of.least(builder.select(entered, begin, of.constant(math.inf)))
        return context.make_tuple(builder, signature.return_type, [of.mask(entered), first])

    return types.Tuple((types.int32, real))(nodes, types.intp, types.UniTuple(types.intp, 3), group), build


@intrinsic
def triangles_met(typing, leaves, first, origin, direction, least, most, distances):
    """Bits of the triangles of a leaf that a ray meets between `least` and `most`, from either side.

    distances: then the weights of the second and the third corners, eight each. A ray through an edge meets one
    of the two triangles there: each compares the ray with the edge by the same products (Plücker coordinates, as
    Embree's; Davis 2013, watertight for one order of corners).
    """
    real = most

    def build(context, builder, signature, arguments):
        table, leaf, origin_, direction_, least_, most_, distances_ = arguments
        data = _data(context, builder, signature.args[0], table)
        out = _data(context, builder, signature.args[6], distances_)
        of = _Vectors(context, builder, real)
        start = [of.spread(builder.extract_value(origin_, axis)) for axis in range(3)]
        way = [of.spread(builder.extract_value(direction_, axis)) for axis in range(3)]
        a, b, c = ([of.sub(of.load(data, builder.add(leaf, ir.Constant(ir.IntType(64), WIDTH * (3 * corner + axis)))),
                           start[axis]) for axis in range(3)] for corner in range(3))

        def edge(p, q) -> ir.Value:
            """The side of the edge from p to q on which the ray passes."""
            along = [of.sub(i, j) for i, j in zip(q, p, strict=True)]
            middle = [of.add(i, j) for i, j in zip(q, p, strict=True)]
            return of.dot(of.cross(along, middle), way)

        first_weight, second_weight, third_weight = edge(b, c), edge(c, a), edge(a, b)
        low = of.smaller(of.smaller(first_weight, second_weight), third_weight)
        high = of.larger(of.larger(first_weight, second_weight), third_weight)
        zero = of.constant(0.0)
        total = of.add(of.add(first_weight, second_weight), third_weight)
        slack = of.mul(of.larger(total, builder.fneg(total)), of.constant(SLACK))
        inside = builder.or_(builder.fcmp_ordered(">=", low, builder.fneg(slack)),
                             builder.fcmp_ordered("<=", high, slack))
        normal = of.cross([of.sub(i, j) for i, j in zip(b, a, strict=True)],
                          [of.sub(i, j) for i, j in zip(c, a, strict=True)])
        distance = builder.fdiv(of.dot(normal, a), of.dot(normal, way))
        inside = builder.and_(inside, builder.fcmp_unordered("!=", total, zero))
        inside = builder.and_(inside, builder.fcmp_ordered(">", distance, of.spread(least_)))
        inside = builder.and_(inside, builder.fcmp_ordered("<", distance, of.spread(most_)))
        for k, value in enumerate((distance, builder.fdiv(second_weight, total), builder.fdiv(third_weight, total))):
            of.store(value, out, ir.Constant(ir.IntType(64), WIDTH * k))
        return of.mask(inside)

    three = types.UniTuple(real, 3)
    return types.int32(leaves, types.intp, three, three, real, real, distances), build


@intrinsic
def lowest_bit(typing, mask):
    """Number of the lowest bit of a mask that is not 0."""
    def build(context, builder, signature, arguments):
        count = builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 1))
        return builder.zext(count, cgutils.intp_t)

    return types.intp(types.int32), build


@intrinsic
def count_of_bits(typing, mask):
    """How many bits of a mask are 1."""
    def build(context, builder, signature, arguments):
        return builder.ctpop(arguments[0])

    return types.int32(types.int32), build
