/* Triangles inside closed polylines.
 * Source: CGAL 5.5, Mesh_2: constrained Delaunay refinement after Shewchuk; what is inside is ours.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bridge.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesh_vertex_base_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <new>
#include <stdexcept>
#include <vector>

namespace
{
typedef CGAL::Exact_predicates_inexact_constructions_kernel kernel;
typedef CGAL::Delaunay_mesh_vertex_base_2<kernel> vertex_base;
typedef CGAL::Delaunay_mesh_face_base_2<kernel> face_base;
typedef CGAL::Triangulation_data_structure_2<vertex_base, face_base> structure;
typedef CGAL::No_constraint_intersection_requiring_constructions_tag no_crossings;
typedef CGAL::Constrained_Delaunay_triangulation_2<kernel, structure, no_crossings> triangulation;
typedef CGAL::Delaunay_mesh_size_criteria_2<triangulation> criteria;
typedef CGAL::Delaunay_mesher_2<triangulation, criteria> mesher;
typedef kernel::Point_2 point;
typedef triangulation::Vertex_handle vertex;
typedef triangulation::Face_handle face;

/* The square of the sine of the least angle, 20.7 degrees: the most that refinement is known to
 * reach. */
const double LEAST_ANGLE = 0.125;

point point_of(const double *at, int i)
{
    const double *p = at + 2 * static_cast<std::ptrdiff_t>(i);
    return point(p[0], p[1]);
}

/* The point after `i` in its loop, which ends before `end`. */
int next_of(const bridge_outline *o, int loop, int i)
{
    return i + 1 < o->loop[loop + 1] ? i + 1 : o->loop[loop];
}

/* ---- crossings -------------------------------------------------------------------------------- */

struct edge {
    kernel::Segment_2 line;
    double low, high; /* x */
    int from, to;
};

bool before(const edge &a, const edge &b)
{
    return a.low < b.low;
}

/* Neighbours have a corner in common, and nothing else. */
bool cross(const edge &a, const edge &b)
{
    const bool joined = a.to == b.from || b.to == a.from;
    if (!CGAL::do_intersect(a.line, b.line)) {
        return false;
    }
    if (!joined) {
        return true;
    }
    const point corner = a.to == b.from ? a.line.target() : b.line.target();
    const point one = a.line.source() == corner ? a.line.target() : a.line.source();
    const point other = b.line.source() == corner ? b.line.target() : b.line.source();
    return CGAL::collinear(one, corner, other) &&
           !CGAL::collinear_are_ordered_along_line(one, corner, other);
}

void put_crossing(const edge &a, const edge &b, double at[3])
{
    const kernel::Vector_2 u = a.line.to_vector(), v = b.line.to_vector(),
                           w = b.line.source() - a.line.source();
    const double whole = u.x() * v.y() - u.y() * v.x();
    double t = whole != 0 ? (w.x() * v.y() - w.y() * v.x()) / whole : 0;
    t = t >= 0 && t <= 1 ? t : 0;
    at[0] = a.line.source().x() + t * u.x();
    at[1] = a.line.source().y() + t * u.y();
    at[2] = 0;
}

int check_crossings(const bridge_outline *o, bridge_fault *fault)
{
    std::vector<edge> edges;
    fault->count = 0;
    for (int loop = 0; loop < o->loop_count; loop++) {
        for (int i = o->loop[loop]; i < o->loop[loop + 1]; i++) {
            const int to = next_of(o, loop, i);
            const point p = point_of(o->at, i), q = point_of(o->at, to);
            edges.push_back(
                {kernel::Segment_2(p, q), std::min(p.x(), q.x()), std::max(p.x(), q.x()), i, to});
        }
    }
    std::stable_sort(edges.begin(), edges.end(), before);
    for (std::size_t i = 0; i < edges.size(); i++) {
        for (std::size_t j = i + 1; j < edges.size() && edges[j].low <= edges[i].high; j++) {
            if (cross(edges[i], edges[j]) && fault->count++ == 0) {
                put_crossing(edges[i], edges[j], fault->at);
            }
        }
    }
    return fault->count > 0 ? BRIDGE_CROSSING : BRIDGE_GOOD;
}

/* ---- what is inside --------------------------------------------------------------------------- */

/* From outside in: a face beyond an edge of the outline is in when this one is not. */
void mark_inside(triangulation &t)
{
    std::map<face, bool> inside;
    std::vector<face> open(1, t.infinite_face());
    inside[open[0]] = false;
    while (!open.empty()) {
        const face f = open.back();
        open.pop_back();
        for (int k = 0; k < 3; k++) {
            const face other = f->neighbor(k);
            if (inside.count(other) == 0) {
                inside[other] = inside[f] != f->is_constrained(k);
                open.push_back(other);
            }
        }
    }
    for (face f : t.all_face_handles()) {
        f->set_in_domain(inside[f]);
    }
}

/* ---- the triangles ---------------------------------------------------------------------------- */

struct builder {
    triangulation t;
    std::map<vertex, int> number;
    std::vector<vertex> order;

    void add(vertex v)
    {
        if (number.emplace(v, static_cast<int>(order.size())).second) {
            order.push_back(v);
        }
    }
};

void give(const bridge_outline *o, builder *b)
{
    std::vector<vertex> at;
    for (int i = 0; i < o->point_count; i++) {
        at.push_back(b->t.insert(point_of(o->at, i)));
        b->add(at.back());
    }
    if (b->order.size() != at.size()) {
        throw std::runtime_error("two points of the outline are in one place");
    }
    for (int loop = 0; loop < o->loop_count; loop++) {
        for (int i = o->loop[loop]; i < o->loop[loop + 1]; i++) {
            b->t.insert_constraint(at[std::size_t(i)], at[std::size_t(next_of(o, loop, i))]);
        }
    }
    for (int i = 0; i < o->inner_count; i++) {
        b->add(b->t.insert(point_of(o->inner, i)));
    }
}

void refine(builder *b, double longest, int vertices_max)
{
    mark_inside(b->t);
    mesher m(b->t, criteria(LEAST_ANGLE, longest));
    m.init(true);
    while (m.try_one_step_refine_mesh()) {
        if (b->t.number_of_vertices() > std::size_t(vertices_max)) {
            throw std::runtime_error("it takes too many triangles");
        }
    }
}

/* In the order in which a vertex is met first: of the triangulation's, which its history alone
 * decides. */
void take(builder *b, bridge_mesh *out)
{
    std::vector<face> inside;
    for (face f : b->t.finite_face_handles()) {
        if (f->is_in_domain()) {
            inside.push_back(f);
            for (int k = 0; k < 3; k++) {
                b->add(f->vertex(k));
            }
        }
    }
    out->at = static_cast<double *>(std::malloc(3 * b->order.size() * sizeof *out->at));
    out->triangle =
        static_cast<int(*)[3]>(std::malloc((inside.size() + 1) * sizeof *out->triangle));
    if (out->at == nullptr || out->triangle == nullptr) {
        throw std::bad_alloc();
    }
    for (vertex v : b->order) {
        double *at = out->at + 3 * static_cast<std::ptrdiff_t>(out->vertex_count++);
        at[0] = v->point().x();
        at[1] = v->point().y();
        at[2] = 0;
    }
    for (face f : inside) {
        int *corner = out->triangle[out->triangle_count++];
        for (int k = 0; k < 3; k++) {
            corner[k] = b->number[f->vertex(k)];
        }
    }
}
} // namespace

void bridge_mesh_free(bridge_mesh *m)
{
    std::free(m->at);
    std::free(m->triangle);
    *m = bridge_mesh();
}

/* Nothing may unwind into C. */
int bridge_triangulate(const bridge_outline *o, bridge_mesh *out, bridge_fault *fault,
                       bridge_message *message)
{
    *out = bridge_mesh();
    try {
        builder b;
        if (check_crossings(o, fault) != BRIDGE_GOOD) {
            return BRIDGE_CROSSING;
        }
        give(o, &b);
        refine(&b, o->longest, o->vertices_max);
        take(&b, out);
        return BRIDGE_GOOD;
    } catch (const std::exception &e) {
        std::snprintf(message->text, sizeof message->text, "%s", e.what());
    } catch (...) {
        std::snprintf(message->text, sizeof message->text, "CGAL gave up");
    }
    bridge_mesh_free(out);
    return -1;
}
