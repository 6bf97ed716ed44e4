// Constructive solid geometry on the intervals of a line.
//
// Roth, "Ray Casting for Modeling Solids", CGIP 18(2), 1982, without the merging of interval lists: all crossings of
// the operands are sorted along the line, and walking through them keeps a counter in every node of the tree. A
// crossing of the result is where the root's state changes. The tree is walked upwards from the operand only as far
// as a state changes, without recursion, so depth costs no stack.
//
// Crossings whose distance is within the sum of their error bounds are one event: states are compared before and after
// all of them. So coincident faces leave no sliver: a union loses the wall between its parts, a difference with a flush
// face loses that face. Where several operands could give the surface, the first in the order of the scene does.
#pragma once

#include "scene/trace.h"

namespace tilecast {

// The crossings of the result along the whole line, sorted, entries and exits in turn. Valid until the next call on
// this thread.
const std::vector<Crossing>& crossings(const Scene& scene, const Csg& csg, const Ray& line, uint64_t base);

}  // namespace tilecast
