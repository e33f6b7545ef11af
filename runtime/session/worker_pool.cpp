#include "session/worker_pool.h"

namespace fjell::session {

WorkerPool::WorkerPool(std::uint32_t workers) {
    for (std::uint32_t worker = 1; worker < workers; ++worker) threads_.emplace_back([this] { work(); });
}

WorkerPool::~WorkerPool() {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    begun_.notify_all();
}

void WorkerPool::help(std::unique_lock<std::mutex>& lock) {
    while (loop_.next != loop_.count) {
        const Loop loop = loop_;
        ++loop_.next;
        lock.unlock();
        loop.job(loop.data, loop.next);
        lock.lock();
        if (++loop_.done == loop_.count) ended_.notify_one();
    }
}

void WorkerPool::work() {
    std::unique_lock lock(mutex_);
    for (;;) {
        begun_.wait(lock, [this] { return stop_ || loop_.next != loop_.count; });
        if (stop_) return;
        help(lock);
    }
}

void WorkerPool::run(void* user, std::uint32_t count, void (*job)(void*, std::uint32_t), void* data) {
    WorkerPool& pool = *static_cast<WorkerPool*>(user);
    std::unique_lock lock(pool.mutex_);
    pool.loop_ = {count, 0, 0, job, data};
    pool.begun_.notify_all();
    pool.help(lock);
    pool.ended_.wait(lock, [&pool] { return pool.loop_.done == pool.loop_.count; });
}

} // namespace fjell::session
