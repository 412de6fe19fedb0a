/* The device headers on a GPU: values and samples a second, beside the memory's bandwidth of the same run.
 *
 *     make install-c PREFIX=$PWD/build/prefix
 *     nvcc -O3 -arch=native -Ibuild/prefix/include benches/device.cu -Lbuild/prefix/lib -lbsdfkit -o build/device
 *     LD_LIBRARY_PATH=build/prefix/lib build/device FILE...       (-DBSDFKIT_REAL=float: single precision)
 *
 * FILE is a BSDF whose first component is a tree or a matrix; benches/query.py leaves tree6.xml and klems.xml.
 * Directions are random, so neighbouring threads share no cell: the least favourable case. A value
 * reads two directions and writes a number; besides, a tree's reads one 32-byte sector a level. What these
 * sum up to, divided by time and by the bandwidth of a copy within the device, is the share printed; more
 * than 1 says that caches helped. Values and totals are compared with the library's answers on the host.
 *
 * It has been compiled (CUDA 13, both precisions; the headers by NVRTC, too), and NOT yet been run on a GPU:
 * there are no figures of one. What the headers compute is tested on the CPU, in tests/install. */
#include <bsdfkit.h>
#include <bsdfkit_device_matrix.h>
#include <cuda_runtime.h>
#include <cstdio>
#include <cstdlib>
#include <vector>

enum { QUERIES = 1 << 24, CHECKED = 100000, RUNS = 10, BLOCK = 256, SECTOR = 32 };

static void check(cudaError_t status)
{
    if (status != cudaSuccess) {
        fprintf(stderr, "CUDA: %s\n", cudaGetErrorString(status));
        exit(1);
    }
}

template <class T> static T *upload(const T *host, size_t count)
{
    T *device = nullptr;
    check(cudaMalloc(&device, count * sizeof(T)));
    if (host)
        check(cudaMemcpy(device, host, count * sizeof(T), cudaMemcpyHostToDevice));
    return device;
}

/* The functions of either header by one name. */
__device__ bsdfkit_real value(const bsdfkit_tree &t, const bsdfkit_real *wi, const bsdfkit_real *wo)
{
    return bsdfkit_device_eval(&t, wi, wo);
}
__device__ bsdfkit_real value(const bsdfkit_matrix &m, const bsdfkit_real *wi, const bsdfkit_real *wo)
{
    return bsdfkit_device_matrix_eval(&m, wi, wo);
}
__device__ bsdfkit_device_sample_result draw(const bsdfkit_tree &t, const bsdfkit_real *wi, bsdfkit_real u)
{
    return bsdfkit_device_sample(&t, wi, u);
}
__device__ bsdfkit_device_sample_result draw(const bsdfkit_matrix &m, const bsdfkit_real *wi, bsdfkit_real u)
{
    return bsdfkit_device_matrix_sample(&m, wi, u);
}
__device__ bsdfkit_device_sample_result draw(const bsdfkit_tree &t, const bsdfkit_real *wi,
                                             const bsdfkit_real *u)
{
    return bsdfkit_device_sample_2(&t, wi, u);
}
__device__ bsdfkit_device_sample_result draw(const bsdfkit_matrix &m, const bsdfkit_real *wi,
                                             const bsdfkit_real *u)
{
    return bsdfkit_device_matrix_sample_2(&m, wi, u);
}

template <class Component>
__global__ void eval(Component c, const bsdfkit_real *wi, const bsdfkit_real *wo, bsdfkit_real *out)
{
    const size_t n = (size_t)blockIdx.x * BLOCK + threadIdx.x;
    out[n] = value(c, wi + 3 * n, wo + 3 * n);
}

template <class Component>
__global__ void sample(Component c, const bsdfkit_real *wi, const bsdfkit_real *u,
                       bsdfkit_device_sample_result *out)
{
    const size_t n = (size_t)blockIdx.x * BLOCK + threadIdx.x;
    out[n] = draw(c, wi + 3 * n, u[2 * n]);
}

template <class Component>
__global__ void sample_2(Component c, const bsdfkit_real *wi, const bsdfkit_real *u,
                         bsdfkit_device_sample_result *out)
{
    const size_t n = (size_t)blockIdx.x * BLOCK + threadIdx.x;
    out[n] = draw(c, wi + 3 * n, u + 2 * n);
}

/* Best of some, in seconds. */
template <class Run> static double seconds(Run run)
{
    cudaEvent_t from, to;
    check(cudaEventCreate(&from));
    check(cudaEventCreate(&to));
    float best = 1e30f;
    for (int n = 0; n < RUNS; n++) {
        float taken = 0;
        check(cudaEventRecord(from));
        run();
        check(cudaEventRecord(to));
        check(cudaEventSynchronize(to));
        check(cudaGetLastError());
        check(cudaEventElapsedTime(&taken, from, to));
        best = taken < best ? taken : best;
    }
    return 1e-3 * best;
}

static double number()
{
    static uint64_t state = 1;
    state += 0x9e3779b97f4a7c15u;
    uint64_t z = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
}

static std::vector<bsdfkit_real> directions(double side)
{
    std::vector<bsdfkit_real> w(3 * (size_t)QUERIES);
    for (size_t n = 0; n < w.size(); n += 3) {
        const double angle = 2 * BSDFKIT_PI * number(), sine = sqrt(number());
        w[n] = (bsdfkit_real)(sine * cos(angle));
        w[n + 1] = (bsdfkit_real)(sine * sin(angle));
        w[n + 2] = (bsdfkit_real)(side * sqrt(1 - sine * sine));
    }
    return w;
}

static void three(const std::vector<bsdfkit_real> &w, size_t n, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = (double)w[3 * n + k];
}

/* `component` holds pointers into the device; `is_tree`: its look-ups go down a tree. */
template <class Component>
static void bench(const bsdfkit_bsdf *bsdf, const char *file, const Component &component, bool is_tree)
{
    const auto wi = directions(component.incident), wo = directions(component.scattered);
    std::vector<bsdfkit_real> u(2 * (size_t)QUERIES);
    for (auto &x : u)
        x = (bsdfkit_real)number();
    bsdfkit_real *d_wi = upload(wi.data(), wi.size()), *d_wo = upload(wo.data(), wo.size());
    bsdfkit_real *d_u = upload(u.data(), u.size()), *d_out = upload<bsdfkit_real>(nullptr, QUERIES);
    auto *d_samples = upload<bsdfkit_device_sample_result>(nullptr, QUERIES);
    const int blocks = QUERIES / BLOCK;

    const size_t copied = wi.size() * sizeof wi[0];
    const double copy = seconds([&] { cudaMemcpyAsync(d_wo, d_wi, copied, cudaMemcpyDeviceToDevice); });
    const double bandwidth = 2.0 * copied / copy;
    check(cudaMemcpy(d_wo, wo.data(), copied, cudaMemcpyHostToDevice));

    const double t_eval = seconds([&] { eval<<<blocks, BLOCK>>>(component, d_wi, d_wo, d_out); });
    const double t_one = seconds([&] { sample<<<blocks, BLOCK>>>(component, d_wi, d_u, d_samples); });
    std::vector<bsdfkit_device_sample_result> samples(CHECKED);
    check(cudaMemcpy(samples.data(), d_samples, CHECKED * sizeof samples[0], cudaMemcpyDeviceToHost));
    const double t_two = seconds([&] { sample_2<<<blocks, BLOCK>>>(component, d_wi, d_u, d_samples); });
    std::vector<bsdfkit_real> values(CHECKED);
    check(cudaMemcpy(values.data(), d_out, CHECKED * sizeof values[0], cudaMemcpyDeviceToHost));

    const uint32_t parts = BSDFKIT_NON_LAMBERTIAN | (component.incident == component.scattered
                                                         ? BSDFKIT_REFLECTION
                                                         : BSDFKIT_TRANSMISSION);
    const double tolerance = sizeof(bsdfkit_real) == 4 ? 1e-4 : 1e-6;
    int differ = 0;
    double sectors = 0;
    for (size_t n = 0; n < CHECKED; n++) {
        double i[3], o[3], cells[2];
        three(wi, n, i);
        three(wo, n, o);
        const double f = bsdfkit_eval(bsdf, i, o), total = bsdfkit_hemispherical(bsdf, i, parts);
        differ += !(fabs((double)values[n] - f) <= tolerance * (1 + f));
        differ += !(fabs((double)samples[n].weight - total) <= tolerance * (1 + total));
        bsdfkit_projected_solid_angle(bsdf, i, o, cells);
        /* A leaf of 4^-level of the square lies below `level` branches. */
        sectors += is_tree ? log(BSDFKIT_PI / cells[0]) / log(4.0) / CHECKED : 0;
    }
    const double streamed = 7.0 * sizeof(bsdfkit_real), share = QUERIES * (streamed + sectors * SECTOR) / bandwidth;
    printf("%s: %d of %d answers differ from the host's; copies at %.0f GB/s\n", file, differ, 2 * CHECKED,
           bandwidth / 1e9);
    printf("  eval     %8.0f M/s, %.2f of the bandwidth (%.1f sectors)\n", QUERIES / t_eval / 1e6, share / t_eval,
           sectors);
    const double drawn = 4.0 * sizeof(bsdfkit_real) + sizeof(bsdfkit_device_sample_result);
    /* Down by records of one sector each, and down again for the density. */
    const double walked = QUERIES * (drawn + 2 * sectors * SECTOR) / bandwidth;
    printf("  sample   %8.0f M/s, %.2f of the bandwidth\n", QUERIES / t_one / 1e6, walked / t_one);
    printf("  sample 2 %8.0f M/s, %.2f of the bandwidth\n", QUERIES / t_two / 1e6, walked / t_two);
    for (void *p : {(void *)d_wi, (void *)d_wo, (void *)d_u, (void *)d_out, (void *)d_samples})
        check(cudaFree(p));
}

int main(int argc, char **argv)
{
    int device = 0;
    cudaDeviceProp about;
    check(cudaGetDevice(&device));
    check(cudaGetDeviceProperties(&about, device));
    printf("%s, %d bits, %d random pairs of directions\n", about.name, (int)(8 * sizeof(bsdfkit_real)), QUERIES);
    for (int k = 1; k < argc; k++) {
        bsdfkit_error *error = nullptr;
        bsdfkit_bsdf *bsdf = bsdfkit_open(argv[k], &error);
        bsdfkit_tree tree;
        bsdfkit_matrix matrix;
        if (bsdf && bsdfkit_tree_at(bsdf, 0, &tree, nullptr) == BSDFKIT_OK) {
            tree.slots = upload(tree.slots, tree.slots_length);
            tree.index = upload(tree.index, tree.index_length);
            tree.slices = upload(tree.slices, tree.slices_length);
            tree.records = upload(tree.records, tree.records_length);
            bench(bsdf, argv[k], tree, true);
        } else if (bsdf && bsdfkit_matrix_at(bsdf, 0, &matrix, &error) == BSDFKIT_OK) {
            matrix.values = upload(matrix.values, (size_t)matrix.rows * matrix.columns);
            matrix.incident_rings = upload(matrix.incident_rings, 2 * (size_t)matrix.incident_count);
            matrix.scattered_rings = upload(matrix.scattered_rings, 2 * (size_t)matrix.scattered_count);
            bench(bsdf, argv[k], matrix, false);
        } else {
            fprintf(stderr, "%s\n", bsdfkit_error_message(error));
            return 1;
        }
        bsdfkit_close(bsdf);
    }
    return 0;
}
