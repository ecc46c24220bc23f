#include "reduced_homotopy.hpp"

#include "reduced_tracker.hpp"

namespace gsp {

void GSP_TRACK_VALUES(const ReducedGeometry& geometry, const ReducedOptions& options, const ReducedPaths& paths,
                    int begin, int end, const ReducedEnds& ends) {
  const auto run = [&]<int M, bool has_h>() {
    const auto with = [&]<class Moving>() {
      ReducedTracker<M, has_h, Moving>(geometry, options, paths, begin, end, ends).run();
    };
    if (!paths.line)
      with.template operator()<MovingValues>();
#if !defined(GSP_VALUES_ALONE)
    else if (paths.line->real)
      with.template operator()<MovingPlatform<M>>();
    else
      with.template operator()<MovingGeometry<M>>();
#endif
  };
  switch (2 * geometry.scalars + geometry.has_h) {
    case 0: return run.template operator()<0, false>();
    case 2: return run.template operator()<1, false>();
    case 4: return run.template operator()<2, false>();
    case 6: return run.template operator()<3, false>();
    case 3: return run.template operator()<1, true>();
    case 5: return run.template operator()<2, true>();
    case 7: return run.template operator()<3, true>();
  }
}

}  // namespace gsp
