/* Tetrahedra inside a closed triangle surface.
 * Source: TetGen 1.5.0 (H. Si), constrained Delaunay refinement; switches p Y q a S M T Q.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bridge.h"

#define TETLIBRARY
#include <tetgen.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <stdexcept>

namespace
{
/* tetgenio's own destructor releases these with delete[]. */
void give(const bridge_surface *s, const bridge_fill *fill, tetgenio *in)
{
    const std::size_t values = 3 * static_cast<std::size_t>(s->vertex_count);
    const std::size_t inner = 3 * static_cast<std::size_t>(fill->point_count);
    in->firstnumber = 0;
    in->numberofpoints = s->vertex_count + fill->point_count;
    in->pointlist = new REAL[values + inner];
    std::copy(s->at, s->at + values, in->pointlist);
    std::copy(fill->point, fill->point + inner, in->pointlist + values);
    in->numberoffacets = s->triangle_count;
    in->facetlist = new tetgenio::facet[static_cast<std::size_t>(s->triangle_count)];
    for (int i = 0; i < s->triangle_count; i++) {
        tetgenio::init(&in->facetlist[i]); /* all of them, before anything below may throw */
    }
    for (int i = 0; i < s->triangle_count; i++) {
        tetgenio::facet *facet = &in->facetlist[i];
        facet->polygonlist = new tetgenio::polygon[1];
        facet->numberofpolygons = 1;
        tetgenio::init(facet->polygonlist);
        facet->polygonlist->vertexlist = new int[3];
        facet->polygonlist->numberofvertices = 3;
        std::memcpy(facet->polygonlist->vertexlist, s->triangle[i], 3 * sizeof(int));
    }
}

/* Numbers go into the fields of the switches: a text of them would be rounded. The surface's triangles stay
 * as they are (Y), and nothing is merged (M): by default facets that meet at more than 179.9 degrees become
 * one, and close vertices too. */
tetgenbehavior switches(const bridge_fill *fill)
{
    tetgenbehavior b;
    char text[] = "pYq1.3a1MQ";
    if (!b.parse_commandline(text)) {
        throw std::logic_error("TetGen does not know its switches");
    }
    b.minratio = fill->ratio;
    b.epsilon = fill->tolerance;
    b.maxvolume = fill->volume_max;
    b.steinerleft = fill->added_max;
    return b;
}

void take(const bridge_surface *s, const bridge_fill *fill, const tetgenio &from, bridge_tets *out)
{
    const std::size_t points = static_cast<std::size_t>(from.numberofpoints);
    const std::size_t tets = static_cast<std::size_t>(from.numberoftetrahedra);
    const std::size_t kept = 3 * static_cast<std::size_t>(s->vertex_count);
    const std::size_t inner = 3 * static_cast<std::size_t>(fill->point_count);
    if (from.numberofcorners != 4 || 3 * points < kept + inner ||
        !std::equal(s->at, s->at + kept, from.pointlist)) {
        throw std::runtime_error("it has not kept the surface's vertices");
    }
    if (!std::equal(fill->point, fill->point + inner, from.pointlist + kept)) {
        throw std::runtime_error("it has not kept the points inside");
    }
    out->at = static_cast<double *>(std::malloc(3 * points * sizeof *out->at));
    out->tet = static_cast<int(*)[4]>(std::malloc((tets + 1) * sizeof *out->tet));
    if (out->at == nullptr || out->tet == nullptr) {
        throw std::bad_alloc();
    }
    out->vertex_count = from.numberofpoints;
    out->tet_count = from.numberoftetrahedra;
    std::memcpy(out->at, from.pointlist, 3 * points * sizeof *out->at);
    std::memcpy(out->tet, from.tetrahedronlist, tets * sizeof *out->tet);
}

const char *meaning(int code)
{
    switch (code) {
    case 1:
        return "it ran out of memory";
    case 3:
        return "it finds that the surface crosses itself";
    case 4:
        return "it finds features that are too small beside the whole";
    case 5:
        return "it finds two triangles that are too close to each other";
    case 10:
        return "it finds its input wrong";
    default:
        return "an error of its own";
    }
}
} // namespace

void bridge_tets_free(bridge_tets *t)
{
    std::free(t->at);
    std::free(t->tet);
    *t = bridge_tets();
}

/* TetGen leaves through `throw int`; nothing may unwind into C, so every path ends in a catch. */
int bridge_tetgen(const bridge_surface *s, const bridge_fill *fill, bridge_tets *out,
                  bridge_message *message)
{
    *out = bridge_tets();
    try {
        tetgenio in, filled;
        tetgenbehavior b = switches(fill);
        give(s, fill, &in);
        tetrahedralize(&b, &in, &filled);
        take(s, fill, filled, out);
        return 0;
    } catch (int code) {
        std::snprintf(message->text, sizeof message->text, "%s", meaning(code));
    } catch (const std::exception &e) {
        std::snprintf(message->text, sizeof message->text, "%s", e.what());
    } catch (...) {
        std::snprintf(message->text, sizeof message->text, "%s", meaning(0));
    }
    bridge_tets_free(out);
    return -1;
}
