// Cosines and sines by which live pages turn joints, for tests of their error bounds.
#include "joints.cpp"

#include "values.cpp"

// The numbers are those of `Values`; high and low parts of the cosine and the sine, and their size.
extern "C" __attribute__((visibility("default"))) void turned(const double* numbers, double angle,
                                                              double* found) {
  gsp::live::Numbers given(numbers);
  const gsp::live::Values values(given);
  gsp::Doubled cosine, sine;
  gsp::live::turn(values, angle, cosine, sine);
  const double all[] = {cosine.high, cosine.low, sine.high, sine.low, cosine.size};
  for (int k = 0; k < 5; ++k) found[k] = all[k];
}
