// The same library from C++17: RAII in two lines, batches of std::array.
#include <bsdfkit.h>

#include <array>
#include <cstdio>
#include <memory>
#include <vector>

struct Close {
    void operator()(bsdfkit_bsdf *bsdf) const { bsdfkit_close(bsdf); }
    void operator()(bsdfkit_error *error) const { bsdfkit_error_free(error); }
};
using Bsdf = std::unique_ptr<bsdfkit_bsdf, Close>;
using Error = std::unique_ptr<bsdfkit_error, Close>;
using Direction = std::array<double, 3>;

int main(int argc, char **argv)
{
    if (argc != 2) {
        std::fprintf(stderr, "usage: query_cpp FILE\n");
        return 2;
    }
    bsdfkit_error *fault = nullptr;
    const Bsdf bsdf{bsdfkit_open(argv[1], &fault)};
    if (const Error error{fault}; !bsdf) {
        std::fprintf(stderr, "query_cpp: %s\n", bsdfkit_error_message(error.get()));
        return 1;
    }
    // One incident direction, a fan of scattered ones.
    const Direction wi{0.0, 0.0, 1.0};
    const std::vector<Direction> wo{{0.0, 0.0, 1.0}, {0.6, 0.0, 0.8}, {0.8, 0.0, 0.6}, {0.0, 0.6, -0.8}};
    std::vector<double> f(wo.size()), pdf(wo.size());
    bsdfkit_class done = bsdfkit_eval_many(bsdf.get(), wi.data(), 1, wo.front().data(), wo.size(),
                                           f.data(), f.size(), &fault);
    if (done == BSDFKIT_OK)
        done = bsdfkit_pdf_many(bsdf.get(), wi.data(), 1, wo.front().data(), wo.size(), BSDFKIT_ALL,
                                pdf.data(), pdf.size(), &fault);
    if (const Error error{fault}; done != BSDFKIT_OK) {
        std::fprintf(stderr, "query_cpp: %s\n", bsdfkit_error_message(error.get()));
        return 1;
    }
    for (std::size_t n = 0; n < wo.size(); ++n)
        std::printf("(%g, %g, %g): eval %g 1/sr, pdf %g 1/sr\n", wo[n][0], wo[n][1], wo[n][2], f[n], pdf[n]);
}
