// How somebody stands, walks and runs: one pose for a speed, a direction and a phase. Running ahead
// is cyclic clips that step together; standing, walking and going sideways or backwards place the
// feet.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "shared/base/result.h"
#include "tools/sim/people/figure.h"
#include "tools/sim/people/pose.h"

namespace touchline::sim::people {

// The clips a cast plays, with heights of the lowest point found on the average body.
class ClipLibrary {
 public:
  static base::Result<ClipLibrary> load(const std::filesystem::path& assets, const Human& human);

  struct Action {
    const char* name;
    const char* file;
    bool flip;     // the clip goes to the right: `mirror = false` plays its mirror image
    bool running;  // taken while running: the clip's travel is scaled to the speed
    char down;     // how it ends: 0 on the feet, 'b' on the back, 'f' on the front
  };
  static const std::vector<Action>& actions();
  // None for a name it does not know.
  const Action* find(const std::string& name, const Clip** clip) const;
  const Clip& rise(char down) const { return down == 'b' ? rise_back_ : rise_front_; }

  // Standing, 0 at ease .. 1 ready to spring.
  Pose stand(float ready) const;
  // `speed` m/s of a 1.8 m person, `turn` radians from where the body faces to where it goes,
  // `step` counts steps: even numbers are mid-stance of the left foot.
  // `spin` is how fast the body turns on the spot, rad/s.
  Pose gait(double speed, double turn, double step, float ready, double spin = 0) const;
  // Metres gone in a step, 1.8 m person; sideways and backwards steps are shorter.
  static double step_length(double speed, double turn);

 private:
  struct Cycle {
    Clip even;
    Clip odd;          // empty = the mirror image of `even`
    float travel = 0;  // radians from facing to going, of the even and odd halves together
    Pose at(double step) const;
  };
  Pose directed(const std::vector<Cycle>& cycles, double turn, double step) const;

  Pose ready_;
  Pose ease_;
  std::vector<Cycle> run_;  // straight on, and half turned away
  Cycle sprint_;
  std::vector<Clip> clips_;  // by actions()
  Clip rise_back_;
  Clip rise_front_;
};

}  // namespace touchline::sim::people
