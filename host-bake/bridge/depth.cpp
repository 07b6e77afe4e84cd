/* How deep inside a closed surface points are.
 * Source: CGAL 5.5, AABB_tree. Which side is ours: a point is inside when a ray from it crosses the
 * surface an odd number of times.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bridge.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <vector>

namespace
{
typedef CGAL::Exact_predicates_inexact_constructions_kernel kernel;
typedef kernel::Point_3 point;
typedef std::vector<kernel::Triangle_3> triangles;
typedef CGAL::AABB_triangle_primitive<kernel, triangles::const_iterator> primitive;
typedef CGAL::AABB_tree<CGAL::AABB_traits<kernel, primitive>> tree;

point point_of(const double *at, int i)
{
    const double *p = at + 3 * static_cast<std::ptrdiff_t>(i);
    return point(p[0], p[1], p[2]);
}

/* A ray that meets an edge counts two triangles, one at a vertex any number: three rays vote, whose
 * directions have nothing to do with any mesh. */
bool inside(const tree &t, const point &p)
{
    static const double direction[3][3] = {
        {0.8147, 0.4218, -0.3978}, {-0.3271, 0.9134, 0.2421}, {0.1234, -0.4567, 0.8809}};
    int votes = 0;
    for (const double *d : direction) {
        const kernel::Ray_3 ray(p, kernel::Vector_3(d[0], d[1], d[2]));
        votes += t.number_of_intersected_primitives(ray) % 2 == 1;
    }
    return votes >= 2;
}
} // namespace

/* Nothing may unwind into C. */
int bridge_depth(const bridge_surface *s, const double *at, int count, double *depth,
                 bridge_message *message)
{
    try {
        triangles list;
        for (int i = 0; i < s->triangle_count; i++) {
            const int *c = s->triangle[i];
            list.push_back(kernel::Triangle_3(point_of(s->at, c[0]), point_of(s->at, c[1]),
                                              point_of(s->at, c[2])));
        }
        tree t(list.begin(), list.end());
        t.accelerate_distance_queries();
        for (int i = 0; i < count; i++) {
            const point p = point_of(at, i);
            const double distance = std::sqrt(t.squared_distance(p));
            depth[i] = inside(t, p) ? distance : -distance;
        }
        return 0;
    } catch (const std::exception &e) {
        std::snprintf(message->text, sizeof message->text, "%s", e.what());
    } catch (...) {
        std::snprintf(message->text, sizeof message->text, "CGAL gave up");
    }
    return -1;
}
