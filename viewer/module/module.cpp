// What the page calls: all poses of a platform for other values, what poses measure, proved steps.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "../../native/controller.hpp"
#include "clearance.hpp"
#include "matrices.hpp"
#include "proofs.hpp"

#define EXPORTED extern "C" __attribute__((used, visibility("default")))

namespace gsp::live {
namespace {

class Platform {
 public:
  explicit Platform(Numbers numbers)
      : values_(numbers), pool_(numbers), whole_(numbers), proofs_(numbers), far_(numbers),
        controller_(controller(numbers)) {
    expected_ = numbers.integer();
    centre_ = numbers.doubles(3);
    extent_ = numbers.number();
    if (numbers.integer()) clearance_ = std::make_unique<Clearance>(numbers);
    joints_ = std::make_unique<Joints>(numbers);
    if (!joints_->are_moved()) return;
    proofs_.read(joints_->equations());
    if (clearance_) clearance_->read(joints_->points(false));
  }

  int expected() const { return expected_; }
  Controller& controller() { return *controller_; }
  const Joints& joints() const { return *joints_; }

  // By long steps, by short ones, by all equations, until all poses are proved: as many as there can be.
  Found solve(const double* readings, int most) {
    double values[kEquations];
    place(readings, values);
    Found best(0);
    const auto is_enough = [&](const Ends& ends) {
      Found found = decide(values, ends);
      if (found.poses() >= best.poses()) best = std::move(found);
      return is_complete(best, most);
    };
    for (int stage = 0; stage < pool_.stages(); ++stage)
      if (is_enough(pool_.follow(values_, values, stage))) return best;
    if (pool_.stages() == 0 && is_enough(whole_.follow(values_, *joints_, values, false))) return best;
    is_enough(whole_.follow(values_, *joints_, values, true));
    return best;
  }

  bool is_complete(const Found& found, int most) const {
    if (found.poses() != most) return false;
    // If joints are moved, `decide` has kept only different poses, and some paths end at no pose.
    return joints_->are_moved() || (found.count() == most && found.are_different(proofs_.scale()));
  }

  // As `condition_numbers`: of the controller's pose.
  double condition() const;
  // The sign of the determinant of the Jacobian matrix there, which no regular way changes; zero if it is not certain.
  int sign() const;
  // Of the same pose, zero if nothing is proved.
  double clearance();

 private:
  // The values that the platform has at these readings, where its joints are moved to.
  void place(const double* readings, double* values) {
    values_.correct(readings, values);
    if (joints_->are_moved()) joints_->place(values_, values);
    joints_->hold(values);
  }

  static std::unique_ptr<Controller> controller(Numbers& numbers) {
    const auto kind = numbers.integers<unsigned char>(kEquations);
    const auto either = numbers.integers<unsigned char>(kEquations);
    return std::make_unique<Controller>(kind.data(), either.data(),
                                        numbers.doubles(static_cast<int>(Controller::kNumbers)));
  }

  // The Jacobian matrix about the centre of the platform, rows of norm one; whether there is one.
  bool jacobian(Matrix& J) const;

  Found decide(const double* values, const Ends& ends) const {
    Found near = proofs_.decide(values_, values, ends);
    if (joints_->are_moved()) near.single_out(proofs_.scale());
    if (far_.poses() == 0) return near;
    double given[kOfValue * kEquations];
    values_.proved(values, 0, proofs_.scale(), given);
    return far_.beside(std::move(near), given, proofs_.unit(values_.largest(values)), proofs_.scale());
  }

  Values values_;
  PoolPaths pool_;
  WholePaths whole_;
  Proofs proofs_;
  FarPart far_;
  std::unique_ptr<Controller> controller_;
  int expected_;
  const double* centre_;
  double extent_;
  std::unique_ptr<Joints> joints_;
  std::unique_ptr<Clearance> clearance_;  // none if the points of the platform lie on a line
};

// The rotation of a quaternion of any length.
void rotation(const double* q, double (&R)[3][3]) {
  const double w = q[0], x = q[1], y = q[2], z = q[3], n = w * w + x * x + y * y + z * z;
  const double rows[3][3] = {{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
                             {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
                             {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) R[i][k] = rows[i][k] / n;
}

bool Platform::jacobian(Matrix& J) const {
  double corrected[6];
  if (controller_->jacobian(&J[0][0]) != 0) return false;
  values_.correct(controller_->values(), corrected);
  joints_->hold(corrected);
  const double unit = std::max(extent_, values_.largest(corrected));
  double R[3][3], c[3];
  rotation(controller_->rotation(), R);
  for (int i = 0; i < 3; ++i) c[i] = R[i][0] * centre_[0] + R[i][1] * centre_[1] + R[i][2] * centre_[2];
  for (auto& row : J) {
    const double *f = row + 3;
    const double across[3] = {c[1] * f[2] - c[2] * f[1], c[2] * f[0] - c[0] * f[2], c[0] * f[1] - c[1] * f[0]};
    for (int i = 0; i < 3; ++i) row[i] = (row[i] - across[i]) / (unit > 0.0 ? unit : 1.0);
    const double size = length(row);
    if (!(size > 0.0 && std::isfinite(size))) return false;
    for (double& x : row) x /= size;
  }
  return true;
}

double Platform::condition() const {
  Matrix J, turns{};
  if (!jacobian(J)) return INFINITY;
  decompose(J, turns);
  double least = INFINITY, largest = 0.0;
  for (const auto& row : J) least = std::min(least, length(row)), largest = std::max(largest, length(row));
  return least > 1e-14 * largest ? largest / least : INFINITY;
}

int Platform::sign() const {
  // Rows are of norm one: rounding errors of the determinant are far below this.
  constexpr double kCertain = 1e-9;
  Matrix J;
  if (!jacobian(J)) return 0;
  double determinant = 1.0;
  for (int k = 0; k < 6; ++k) {
    int pivot = k;
    for (int i = k + 1; i < 6; ++i)
      if (std::abs(J[i][k]) > std::abs(J[pivot][k])) pivot = i;
    if (J[pivot][k] == 0.0) return 0;
    if (pivot != k) std::swap(J[pivot], J[k]), determinant = -determinant;
    determinant *= J[k][k];
    for (int i = k + 1; i < 6; ++i)
      for (int l = 5; l >= k; --l) J[i][l] -= J[i][k] / J[k][k] * J[k][l];
  }
  return determinant > kCertain ? 1 : determinant < -kCertain ? -1 : 0;
}

double Platform::clearance() {
  if (!clearance_) return 0.0;
  double R[3][3], values[kEquations];
  if (joints_->are_moved()) place(controller_->values(), values);
  rotation(controller_->rotation(), R);
  return (*clearance_)(R, controller_->position());
}

std::unique_ptr<double[]> numbers;
std::unique_ptr<Platform> platform;
// What the page writes arguments to and reads answers from.
double exchange[64];
std::vector<double> poses;

}  // namespace
}  // namespace gsp::live

using namespace gsp::live;

// Room for the numbers of a platform.
EXPORTED double* gsp_room(int count) {
  platform.reset();
  numbers = std::make_unique<double[]>(count);
  return numbers.get();
}
EXPORTED void gsp_open() { platform = std::make_unique<Platform>(Numbers(numbers.get())); }
EXPORTED double* gsp_exchange() { return exchange; }
EXPORTED int gsp_expected() { return platform->expected(); }

// All poses for the values in `exchange`, of which there are `most`. Returns how many real ones there are; behind `gsp_poses` are R by
// rows and T of each. `exchange` then has how many poses are proved, and whether they are all there are.
EXPORTED int gsp_solve(int most) {
  double values[6];
  std::copy(exchange, exchange + 6, values);
  const Found found = platform->solve(values, most);
  poses.clear();
  for (int k = 0; k < found.count(); ++k) {
    if (!is_pose(found.proved[k]) || !(found.proved[k] & gsp::kReal)) continue;
    for (int i = 0; i < 9; ++i) poses.push_back(found.rotation[9 * k + i].re);
    for (int i = 0; i < 3; ++i) poses.push_back(found.translation[3 * k + i].re);
  }
  exchange[0] = found.poses();
  exchange[1] = platform->is_complete(found, most);
  return static_cast<int>(poses.size()) / 12;
}
EXPORTED double* gsp_poses() { return poses.data(); }

// Starts from the pose in `exchange` (position, quaternion; then the values near which those of cranks and slides
// are); its values are there then.
EXPORTED int gsp_start() {
  auto& controller = platform->controller();
  const int status = platform->joints().are_moved() ? controller.start(exchange, exchange + 7) : controller.start(exchange);
  std::copy_n(platform->controller().values(), 6, exchange);
  return status;
}
EXPORTED double gsp_condition() { return platform->condition(); }
EXPORTED int gsp_sign() { return platform->sign(); }
EXPORTED double gsp_clearance() { return platform->clearance(); }

// A proved step to the values in `exchange`, where position and quaternion are then.
EXPORTED int gsp_forward() {
  const int status = platform->controller().forward(exchange);
  std::copy_n(platform->controller().position(), 3, exchange);
  std::copy_n(platform->controller().rotation(), 4, exchange + 3);
  return status;
}
