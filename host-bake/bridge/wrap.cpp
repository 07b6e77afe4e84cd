/* A closed surface around triangles that are none.
 * Source: CGAL 5.5, alpha_wrap_3 (Portaneri et al. 2022).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bridge.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <vector>

namespace
{
typedef CGAL::Exact_predicates_inexact_constructions_kernel kernel;
typedef kernel::Point_3 point;
typedef CGAL::Surface_mesh<point> mesh;

void take(const mesh &m, bridge_mesh *out)
{
    out->at =
        static_cast<double *>(std::malloc((3 * m.number_of_vertices() + 1) * sizeof *out->at));
    out->triangle =
        static_cast<int(*)[3]>(std::malloc((m.number_of_faces() + 1) * sizeof *out->triangle));
    if (out->at == nullptr || out->triangle == nullptr) {
        throw std::bad_alloc();
    }
    for (mesh::Vertex_index v : m.vertices()) {
        for (int k = 0; k < 3; k++) {
            out->at[3 * std::ptrdiff_t(out->vertex_count) + k] = m.point(v)[k];
        }
        out->vertex_count++;
    }
    for (mesh::Face_index f : m.faces()) {
        int *corner = out->triangle[out->triangle_count++];
        for (mesh::Vertex_index v : vertices_around_face(m.halfedge(f), m)) {
            *corner++ = int(v.idx());
        }
    }
}
} // namespace

/* Triangles without area are left out by CGAL itself. Nothing may unwind into C. */
int bridge_wrap(const bridge_surface *s, double alpha, double offset, bridge_mesh *out,
                bridge_message *message)
{
    *out = bridge_mesh();
    try {
        std::vector<point> points;
        std::vector<std::array<std::size_t, 3>> soup;
        mesh wrapped;
        for (int i = 0; i < s->vertex_count; i++) {
            const double *p = s->at + 3 * static_cast<std::ptrdiff_t>(i);
            points.push_back(point(p[0], p[1], p[2]));
        }
        for (int i = 0; i < s->triangle_count; i++) {
            const int *c = s->triangle[i];
            soup.push_back({std::size_t(c[0]), std::size_t(c[1]), std::size_t(c[2])});
        }
        CGAL::alpha_wrap_3(points, soup, alpha, offset, wrapped);
        wrapped.collect_garbage();
        take(wrapped, out);
        return 0;
    } catch (const std::exception &e) {
        std::snprintf(message->text, sizeof message->text, "%s", e.what());
    } catch (...) {
        std::snprintf(message->text, sizeof message->text, "CGAL gave up");
    }
    bridge_mesh_free(out);
    return -1;
}
