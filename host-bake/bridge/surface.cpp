/* What is wrong with a closed triangle surface, and where.
 * Source: CGAL 5.5, Polygon Mesh Processing; its predicates are exact. The place of a crossing is ours.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bridge.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

#include <boost/iterator/function_output_iterator.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <utility>
#include <vector>

namespace
{
typedef CGAL::Exact_predicates_inexact_constructions_kernel kernel;
typedef kernel::Point_3 point;
typedef CGAL::Surface_mesh<point> mesh;
typedef std::array<std::size_t, 3> corners;
namespace pmp = CGAL::Polygon_mesh_processing;

point point_of(const bridge_surface *s, int vertex)
{
    const double *p = s->at + 3 * static_cast<std::ptrdiff_t>(vertex);
    return point(p[0], p[1], p[2]);
}

kernel::Triangle_3 triangle_of(const bridge_surface *s, std::size_t i)
{
    const int *c = s->triangle[i];
    return kernel::Triangle_3(point_of(s, c[0]), point_of(s, c[1]), point_of(s, c[2]));
}

void put(const point &p, double at[3])
{
    for (int k = 0; k < 3; k++) {
        at[k] = p[k];
    }
}

/* ---- crossings -------------------------------------------------------------------------------- */

/* Where corners and edges of `a` meet `b`: their sum and count. In one plane, corners alone. */
void meet(const kernel::Triangle_3 &a, const kernel::Triangle_3 &b, double sum[3], int *count)
{
    const kernel::Vector_3 normal = CGAL::cross_product(b[1] - b[0], b[2] - b[0]);
    for (int i = 0; i < 3; i++) {
        const point p = a[i], q = a[(i + 1) % 3];
        if (b.has_on(p)) {
            for (int k = 0; k < 3; k++) {
                sum[k] += p[k];
            }
            ++*count;
        }
        const double from = normal * (p - b[0]), to = normal * (q - b[0]);
        const double t = from / (from - to);
        if (!std::isfinite(t) || t < 0 || t > 1 ||
            !CGAL::do_intersect(kernel::Segment_3(p, q), b)) {
            continue;
        }
        for (int k = 0; k < 3; k++) {
            sum[k] += p[k] + t * (q[k] - p[k]);
        }
        ++*count;
    }
}

/* The middle of what two triangles have in common; of the smaller one where rounding leaves nothing. */
void place_of_crossing(const bridge_surface *s, std::size_t i, std::size_t j, double at[3])
{
    const kernel::Triangle_3 a = triangle_of(s, i), b = triangle_of(s, j);
    double sum[3] = {0, 0, 0};
    int count = 0;
    meet(a, b, sum, &count);
    meet(b, a, sum, &count);
    for (int k = 0; k < 3; k++) {
        at[k] = sum[k] / count;
    }
    if (count == 0) {
        put(CGAL::centroid(a.squared_area() < b.squared_area() ? a : b), at);
    }
}

/* Neighbours that only share what they must are not reported. The pair with the smallest numbers is
 * the one that is told: CGAL's order is its own affair. */
bool crosses(const bridge_surface *s, const mesh &m, bridge_fault *fault)
{
    typedef std::pair<mesh::Face_index, mesh::Face_index> faces;
    std::pair<std::size_t, std::size_t> first(m.number_of_faces(), 0);
    std::size_t count = 0;
    pmp::self_intersections(m, boost::make_function_output_iterator([&](const faces &found) {
                                std::size_t i = found.first, j = found.second;
                                first = std::min(first, i < j ? std::make_pair(i, j)
                                                              : std::make_pair(j, i));
                                count++;
                            }));
    if (count > 0) {
        fault->count = static_cast<int>(std::min<std::size_t>(count, 1000000000));
        place_of_crossing(s, first.first, first.second, fault->at);
    }
    return count > 0;
}

/* ---- parts ------------------------------------------------------------------------------------ */

/* Parts do not cross, so one vertex says where all of a part is. */
int count_nested(const std::vector<mesh> &parts, double at[3])
{
    int count = 0;
    std::vector<bool> inside(parts.size(), false);
    for (const mesh &outer : parts) {
        const CGAL::Side_of_triangle_mesh<mesh, kernel> side(outer);
        for (std::size_t i = 0; i < parts.size(); i++) {
            const point p = parts[i].point(*parts[i].vertices().begin());
            if (&parts[i] == &outer || inside[i] || side(p) != CGAL::ON_BOUNDED_SIDE) {
                continue;
            }
            if (count++ == 0) {
                put(p, at);
            }
            inside[i] = true;
        }
    }
    return count;
}

int check_parts(const mesh &m, double *volume, bridge_fault *fault)
{
    std::vector<mesh> parts;
    pmp::split_connected_components(m, parts);
    *volume = 0;
    for (const mesh &part : parts) {
        *volume += std::fabs(pmp::volume(part));
    }
    fault->count = parts.size() > 1 ? count_nested(parts, fault->at) : 0;
    return fault->count > 0 ? BRIDGE_NESTED : BRIDGE_GOOD;
}

int check_solid(const bridge_surface *s, double *volume, bridge_fault *fault)
{
    std::vector<point> points;
    std::vector<corners> soup;
    mesh m;
    for (int i = 0; i < s->vertex_count; i++) {
        points.push_back(point_of(s, i));
    }
    for (int i = 0; i < s->triangle_count; i++) {
        const int *c = s->triangle[i];
        soup.push_back({std::size_t(c[0]), std::size_t(c[1]), std::size_t(c[2])});
    }
    put(points[soup[0][0]], fault->at);
    fault->count = 1;
    if (!pmp::orient_polygon_soup(points, soup)) {
        return BRIDGE_ONE_SIDED;
    }
    /* NDEBUG: what CGAL does not check is checked here. */
    if (!pmp::is_polygon_soup_a_polygon_mesh(soup)) {
        throw std::logic_error("CGAL finds no manifold");
    }
    pmp::polygon_soup_to_polygon_mesh(points, soup, m);
    if (!CGAL::is_closed(m) || m.number_of_faces() != soup.size()) {
        throw std::logic_error("CGAL finds no closed surface");
    }
    return crosses(s, m, fault) ? BRIDGE_CROSSING : check_parts(m, volume, fault);
}

/* Nothing may unwind into C. */
template <typename function> int guard(bridge_message *message, const function &f)
{
    try {
        return f();
    } catch (const std::exception &e) {
        std::snprintf(message->text, sizeof message->text, "%s", e.what());
    } catch (...) {
        std::snprintf(message->text, sizeof message->text, "CGAL gave up");
    }
    return -1;
}
} // namespace

int bridge_check_flat(const bridge_surface *s, bridge_fault *fault, bridge_message *message)
{
    return guard(message, [&] {
        fault->count = 0;
        for (int i = 0; i < s->triangle_count; i++) {
            const kernel::Triangle_3 t = triangle_of(s, std::size_t(i));
            if (t.is_degenerate() && fault->count++ == 0) {
                put(CGAL::centroid(t), fault->at);
            }
        }
        return int(fault->count > 0 ? BRIDGE_FLAT : BRIDGE_GOOD);
    });
}

int bridge_check_solid(const bridge_surface *s, double *volume, bridge_fault *fault,
                       bridge_message *message)
{
    return guard(message, [&] { return check_solid(s, volume, fault); });
}
